#include "encoder/partition/band_cut.h"

#include <algorithm>

namespace psplit {

void BandCut::clear() {
  nodes_.clear();
  arcs_.clear();
  flow_ = 0;
}

void BandCut::end_node(int32_t from_source, int32_t to_sink) {
  const int32_t through = std::min(from_source, to_sink);
  flow_ += through;
  Node node;
  node.first = nodes_.empty() ? 0 : nodes_.back().end;
  node.end = static_cast<uint32_t>(arcs_.size());
  node.terminal = from_source - to_sink;
  nodes_.push_back(node);
}

// The two entries of a link are joined in order.
void BandCut::join_ends() {
  for (uint32_t node = 0; node < size(); ++node)
    for (uint32_t k = nodes_[node].first; k < nodes_[node].end; ++k) {
      const Node& other = nodes_[arcs_[k].to];
      if (arcs_[k].back != kNone) continue;
      for (uint32_t m = other.first; m < other.end; ++m) {
        if (arcs_[m].to != node || arcs_[m].back != kNone || m == k) continue;
        arcs_[m].back = k;
        arcs_[k].back = m;
        break;
      }
    }
}

void BandCut::activate(uint32_t node) {
  if (nodes_[node].is_active) return;
  nodes_[node].is_active = true;
  active_.push_back(node);
}

int64_t BandCut::run() {
  join_ends();
  active_.clear();
  next_active_ = 0;
  stamp_ = 0;
  for (uint32_t i = 0; i < size(); ++i) {
    if (nodes_[i].terminal == 0) continue;
    nodes_[i].side = nodes_[i].terminal > 0 ? Side::kSource : Side::kSink;
    nodes_[i].parent = kTerminal;
    nodes_[i].distance = 1;
    activate(i);
  }
  for (uint32_t bridge; (bridge = grow()) != kNone;) {
    ++stamp_;
    augment(bridge);
    adopt();
  }
  return flow_;
}

// Grows the trees until they meet. Returns the arc between them, from the source's tree to the sink's.
uint32_t BandCut::grow() {
  while (next_active_ < active_.size()) {
    const uint32_t here = active_[next_active_];
    Node& node = nodes_[here];
    if (node.side != Side::kFree) {
      for (uint32_t k = node.first; k < node.end; ++k) {
        if (capacity_from(node.side, k) == 0) continue;
        Node& other = nodes_[arcs_[k].to];
        if (other.side == Side::kFree) {
          other.side = node.side;
          other.parent = arcs_[k].back;
          other.stamp = node.stamp;
          other.distance = node.distance + 1;
          activate(arcs_[k].to);
        } else if (other.side != node.side) {
          return node.side == Side::kSource ? k : arcs_[k].back;
        } else if (other.stamp <= node.stamp && other.distance > node.distance + 1) {
          // Shorter paths keep the trees shallow.
          other.parent = arcs_[k].back;
          other.stamp = node.stamp;
          other.distance = node.distance + 1;
        }
      }
    }
    node.is_active = false;
    ++next_active_;
  }
  return kNone;
}

void BandCut::augment(uint32_t bridge) {
  const uint32_t source_end = arcs_[arcs_[bridge].back].to, sink_end = arcs_[bridge].to;
  // The arc between a node and its parent, in the direction of the flow.
  const auto flow_arc = [&](uint32_t node) {
    const uint32_t parent = nodes_[node].parent;
    return nodes_[node].side == Side::kSource ? arcs_[parent].back : parent;
  };
  int32_t most = arcs_[bridge].capacity;
  const auto root_of = [&](uint32_t node) {
    for (; nodes_[node].parent != kTerminal; node = arcs_[nodes_[node].parent].to)
      most = std::min(most, arcs_[flow_arc(node)].capacity);
    return node;
  };
  const uint32_t from = root_of(source_end), to = root_of(sink_end);
  most = std::min({most, nodes_[from].terminal, -nodes_[to].terminal});

  const auto send = [&](uint32_t arc) {
    arcs_[arc].capacity -= most;
    arcs_[arcs_[arc].back].capacity += most;
    return arcs_[arc].capacity == 0;
  };
  const auto orphan = [&](uint32_t node) {
    nodes_[node].parent = kNone;
    orphans_.push_back(node);
  };
  // Reads a node's parent before it orphans the node, because the walk continues at the parent.
  const auto send_along = [&](uint32_t node) {
    while (nodes_[node].parent != kTerminal) {
      const uint32_t above = arcs_[nodes_[node].parent].to;
      if (send(flow_arc(node))) orphan(node);
      node = above;
    }
  };
  send(bridge);
  send_along(source_end);
  send_along(sink_end);
  if ((nodes_[from].terminal -= most) == 0) orphan(from);
  if ((nodes_[to].terminal += most) == 0) orphan(to);
  flow_ += most;
}

void BandCut::adopt() {
  for (size_t i = 0; i < orphans_.size(); ++i) adopt(orphans_[i]);
  orphans_.clear();
}

// Whether a path leads from a node up to its terminal; sets `distance` to the length of that path.
bool BandCut::is_rooted(uint32_t node, uint32_t& distance) {
  uint32_t steps = 0, at = node;
  for (;; ++steps) {
    if (nodes_[at].stamp == stamp_) {
      steps += nodes_[at].distance;
      break;
    }
    if (nodes_[at].parent == kTerminal) {
      nodes_[at].stamp = stamp_;
      nodes_[at].distance = 1;
      steps += 1;
      break;
    }
    if (nodes_[at].parent == kNone) return false;
    at = arcs_[nodes_[at].parent].to;
  }
  distance = steps;
  for (at = node; nodes_[at].stamp != stamp_; at = arcs_[nodes_[at].parent].to) {
    nodes_[at].stamp = stamp_;
    nodes_[at].distance = steps--;
  }
  return true;
}

void BandCut::adopt(uint32_t here) {
  Node& node = nodes_[here];
  // The new parent is the one nearest to the terminal.
  uint32_t nearest = kNone;
  for (uint32_t k = node.first; k < node.end; ++k) {
    const uint32_t other = arcs_[k].to;
    if (nodes_[other].side != node.side || capacity_from(node.side, arcs_[k].back) == 0) continue;
    uint32_t distance = 0;
    if (nodes_[other].parent == kNone || !is_rooted(other, distance) || distance >= nearest) continue;
    nearest = distance;
    node.parent = k;
  }
  if (nearest != kNone) {
    node.stamp = stamp_;
    node.distance = nearest + 1;
    return;
  }
  for (uint32_t k = node.first; k < node.end; ++k) {
    const uint32_t other = arcs_[k].to;
    if (nodes_[other].side != node.side) continue;
    if (capacity_from(node.side, arcs_[k].back) != 0) activate(other);
    if (nodes_[other].parent < kTerminal && arcs_[nodes_[other].parent].to == here) {
      nodes_[other].parent = kNone;
      orphans_.push_back(other);
    }
  }
  node.side = Side::kFree;
  // is_active is not changed: the node may be in the queue, which skips it while it is free.
}

}  // namespace psplit
