#include "encoder/stream/source_table.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "encoder/stream/hub_edges.h"

namespace psplit {
namespace {

// The edges that leave a vertex, in the order of their faces. An edge is given by the corner across from it.
struct LeavingEdge {
  uint32_t to;
  uint32_t corner;  // kLinked after the first face that comes the other way
};
constexpr uint32_t kLinked = HubEdges::kNone;

// The part of the array of edges that a vertex has.
struct EdgeList {
  uint32_t begin = 0, end = 0;
};

// A vertex that more edges leave is a hub (hub_edges.h).
constexpr uint32_t kMostListed = 64;

bool is_flat(const SourceTable::Face& face) {
  const uint32_t* const v = face.vertex;
  return v[0] == v[1] || v[0] == v[2] || v[1] == v[2];
}

// The left ends of the fans of some vertices, while links are broken. To walk there from every corner would
// take time quadratic in the faces of a fan.
//
// A walk sees a fan from its left end up to where it breaks the fan, or all of it. So corners to the left of
// one that was not seen were not seen either.
class FanEnds {
 public:
  FanEnds(const SourceTable& table, std::span<const uint32_t> corners)
      : place_(size_t{4} * table.face_count(), kNone) {
    for (const uint32_t corner : corners) {
      if (place_[corner] != kNone) continue;
      const uint32_t none = table.no_corner();
      uint32_t first = corner;
      for (uint32_t left = table.swing_left(first); left != corner && left != none;
           left = table.swing_left(first))
        first = left;
      const bool is_cycle = table.swing_left(first) != none;
      const auto begin = static_cast<uint32_t>(corner_at_.size());
      for (uint32_t at = first; at != none && place_[at] == kNone; at = table.swing_right(at)) {
        place_[at] = static_cast<uint32_t>(corner_at_.size());
        corner_at_.push_back(at);
      }
      begins_.push_back(begin);
      if (!is_cycle) ends_.insert(begin);
    }
  }

  // The corner is a left end from now on.
  void add(uint32_t corner) {
    if (place_[corner] != kNone) ends_.insert(place_[corner]);
  }

  uint32_t first_of(uint32_t corner, const SourceTable& table) const {
    const uint32_t place = place_[corner];
    const auto fan = std::upper_bound(begins_.begin(), begins_.end(), place);
    const uint32_t begin = *std::prev(fan);
    const uint32_t end = fan == begins_.end() ? static_cast<uint32_t>(corner_at_.size()) : *fan;
    const auto after = ends_.upper_bound(place);
    if (after != ends_.begin() && *std::prev(after) >= begin) return corner_at_[*std::prev(after)];
    // The place of the corner in a cycle is before all ends: the last of them is the one to its left.
    const auto last = ends_.lower_bound(end);
    if (last != ends_.begin() && *std::prev(last) >= begin) return corner_at_[*std::prev(last)];
    return table.swing_right(corner);
  }

 private:
  static constexpr uint32_t kNone = ~uint32_t{0};

  std::vector<uint32_t> place_;      // of each corner, in the order of fans from left to right
  std::vector<uint32_t> corner_at_;  // of each place
  std::vector<uint32_t> begins_;     // the places where fans begin
  std::set<uint32_t> ends_;          // the places of left ends
};

}  // namespace

SourceTable::SourceTable(std::span<const std::array<uint32_t, 3>> faces,
                         std::span<const uint32_t> vertex_of_point, uint32_t vertex_limit,
                         std::span<const std::array<uint32_t, 3>> neighbours)
    : face_count_(static_cast<uint32_t>(faces.size())), faces_(new Face[faces.size() + 1]) {
  const uint32_t none = no_corner();
  for (size_t i = 0; i < faces.size(); ++i) {
    Face& face = faces_[i];
    face = {{}, Face::kUnseen, {none, none, none}, 0};
    for (int k = 0; k < 3; ++k) face.vertex[k] = vertex_of_point[faces[i][static_cast<size_t>(k)]];
    if (!is_flat(face)) continue;
    ++flat_count_;
    face.mark = Face::kSeen;
    face.fans_seen = 0b111;
  }
  faces_[face_count_] = {{}, Face::kSeen, {none, none, none}, 0b111};
  if (neighbours.empty() || !link_neighbours(neighbours))
    if (const std::vector<bool> may_fold = link_faces(vertex_limit); !may_fold.empty())
      break_folds(may_fold, vertex_limit);
  separate_fans(vertex_limit);
}

// Makes the links of link_faces, if no edge has more than two faces and no face is flat. Where the two faces of
// an edge have it in the same direction, or are one face upside down, it makes no links at all, and returns
// false. Faces whose points at the edge have other vertices are not linked.
bool SourceTable::link_neighbours(std::span<const std::array<uint32_t, 3>> neighbours) {
  if (flat_count_ > 0) return false;
  for (uint32_t i = 0; i < face_count_; ++i)
    for (uint32_t c = 0; c < 3; ++c) {
      const uint32_t other = neighbours[i][c];
      if (other >= face_count_) continue;
      const uint32_t from = faces_[i].vertex[c], to = faces_[i].vertex[core::next(c)], apex = core::previous(c);
      const Face& across = faces_[other];
      // Which corner is across cannot be predicted, so nothing branches on it.
      const uint32_t v0 = across.vertex[0], v1 = across.vertex[1], v2 = across.vertex[2],
                     tip = v0 ^ v1 ^ v2 ^ from ^ to,  // the third vertex, if the face has `from` and `to`
          at = (tip == v1 ? 1u : 0u) | (tip == v2 ? 2u : 0u);
      const uint32_t after = across.vertex[core::next(at)], before = across.vertex[core::previous(at)];
      if (((after ^ to) | (before ^ from)) == 0 && tip != faces_[i].vertex[apex]) [[likely]] {
        faces_[i].opposite[apex] = 4 * other + at;
        continue;
      }
      const auto has = [&](uint32_t vertex) { return v0 == vertex || v1 == vertex || v2 == vertex; };
      if (!has(from) || !has(to)) continue;
      for (uint32_t f = 0; f < face_count_; ++f) std::ranges::fill(faces_[f].opposite, no_corner());
      return false;
    }
  return true;
}

// Links each edge to the first edge that runs the other way, is not linked yet, and does not belong to the same
// face upside down. Returns the vertices whose fans may have folds: the ends of edges that have more faces than
// the two that are linked there. Empty if there are none.
std::vector<bool> SourceTable::link_faces(uint32_t vertex_limit) {
  std::vector<EdgeList> lists(vertex_limit);
  for (uint32_t i = 0; i < face_count_; ++i)
    if (faces_[i].mark == Face::kUnseen)
      for (const uint32_t vertex : faces_[i].vertex) ++lists[vertex].end;
  uint32_t edge_count = 0;
  for (EdgeList& list : lists) {
    const uint32_t count = list.end;
    list = {edge_count, edge_count};
    edge_count += count;
  }
  const std::unique_ptr<LeavingEdge[]> edges(new LeavingEdge[edge_count]);
  HubEdges hub_edges;  // edges from vertices whose lists are longer than kMostListed
  std::vector<bool> may_fold;
  const auto note_fold = [&](uint32_t from, uint32_t to) {
    if (may_fold.empty()) may_fold.resize(vertex_limit);
    may_fold[from] = may_fold[to] = true;
  };
  // Takes the edge `to` - `from` that a new edge of a face with this apex is linked to; kNone if there is none.
  const auto take_back = [&](uint32_t from, uint32_t to, uint32_t apex) {
    const EdgeList back = lists[to];
    if (back.end - back.begin > kMostListed) {
      const HubEdges::Found found = hub_edges.take(to, from, apex);
      if (found.passed_some) note_fold(from, to);
      return found.corner;
    }
    for (uint32_t at = back.begin; at < back.end; ++at) {
      if (edges[at].to != from) continue;
      if (edges[at].corner != kLinked && vertex(edges[at].corner) != apex)
        return std::exchange(edges[at].corner, kLinked);
      note_fold(from, to);
    }
    return HubEdges::kNone;
  };
  const auto add = [&](uint32_t from, uint32_t to, uint32_t corner) {
    EdgeList& list = lists[from];
    const auto add_to_hub = [&](const LeavingEdge& edge) {
      const uint32_t apex = edge.corner == kLinked ? kLinked : vertex(edge.corner);
      if (hub_edges.add(from, edge.to, edge.corner, apex)) note_fold(from, edge.to);
    };
    if (list.end - list.begin > kMostListed) {
      add_to_hub({to, corner});
      ++list.end;
      return;
    }
    for (uint32_t other = list.begin; other < list.end; ++other)
      if (edges[other].to == to) note_fold(from, to);
    edges[list.end++] = {to, corner};
    if (list.end - list.begin > kMostListed)
      for (uint32_t at = list.begin; at < list.end; ++at) add_to_hub(edges[at]);
  };
  for (uint32_t i = 0; i < face_count_; ++i) {
    Face& face = faces_[i];
    if (face.mark != Face::kUnseen) continue;
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t corner = 4 * i + k, from = face.vertex[core::next(k)], to = face.vertex[core::previous(k)];
      const uint32_t across = take_back(from, to, face.vertex[k]);
      if (across == HubEdges::kNone) {
        add(from, to, corner);
        continue;
      }
      face.opposite[k] = across;
      this->face(across).opposite[across & 3] = corner;
    }
  }
  return may_fold;
}

void SourceTable::unlink(uint32_t corner) {
  uint32_t& across = face(corner).opposite[corner & 3];
  if (across == no_corner()) return;
  face(across).opposite[across & 3] = no_corner();
  across = no_corner();
}

// Walks clockwise around each vertex that may have a fold. If the edge ahead was passed before, both are
// unlinked, and the rest of the fan is left for later: its faces may have become other fans. The result depends
// on the order.
void SourceTable::break_folds(const std::vector<bool>& may_fold, uint32_t vertex_limit) {
  std::vector<uint32_t> corners;  // of these vertices
  for (uint32_t corner = 0; corner < no_corner(); ++corner)
    if ((corner & 3) != 3 && face(corner).mark == Face::kUnseen && may_fold[vertex(corner)])
      corners.push_back(corner);
  std::vector<bool> seen(size_t{4} * face_count_);
  // For each vertex the last walk that passed an edge to it, and the corner across from this edge. No walk
  // passes two edges to one vertex.
  struct Passed {
    uint32_t walk = 0, corner = 0;
  };
  std::vector<Passed> passed(vertex_limit);
  uint32_t walk_count = 0;
  std::optional<FanEnds> ends;
  const auto unlink_both = [&](uint32_t corner) {
    const uint32_t across = opposite(corner);
    if (ends && across != no_corner())
      for (const uint32_t side : {corner, across}) ends->add(core::previous(side));
    unlink(corner);
  };
  // Walks on from `first`. Returns whether links were broken.
  const auto walk = [&](uint32_t first) {
    ++walk_count;
    uint32_t at = first;
    do {
      seen[at] = true;
      const uint32_t corner = core::previous(at);
      const Passed edge = passed[vertex(core::next(at))];
      // If it is linked to this one, the walk comes back to where it began.
      if (edge.walk == walk_count && opposite(corner) != edge.corner) {
        unlink_both(corner);
        unlink_both(edge.corner);
        return true;
      }
      passed[vertex(core::previous(at))] = {walk_count, core::next(at)};
      at = swing_right(at);
    } while (at != first && at != no_corner());
    return false;
  };
  // The first corner to the left that no walk has seen yet, without a seen one between.
  const auto first_of = [&](uint32_t corner) {
    constexpr size_t kMostSteps = 64;
    uint32_t first = corner;
    size_t steps = 0;
    for (uint32_t left = swing_left(first); left != corner && left != no_corner() && !seen[left];
         left = swing_left(first)) {
      if (++steps > kMostSteps) {
        if (!ends) ends.emplace(*this, corners);
        return ends->first_of(corner, *this);
      }
      first = left;
    }
    return first;
  };
  for (bool broken = true; std::exchange(broken, false);)
    for (const uint32_t corner : corners)
      if (!seen[corner]) broken |= walk(first_of(corner));
}

// Sets the states of all vertices as if each had one fan. Returns how many corners of each vertex are in
// another fan than the one that was found, or nothing if no vertex has any.
std::vector<uint32_t> SourceTable::see_fans(uint32_t vertex_limit) {
  const uint32_t none = no_corner();
  std::vector<uint32_t> corner_of(vertex_limit, none), others(vertex_limit);
  for (uint32_t i = 0; i < face_count_; ++i)
    if (faces_[i].mark == Face::kUnseen)
      for (uint32_t k = 0; k < 3; ++k) corner_of[faces_[i].vertex[k]] = 4 * i + k;
  uint64_t seen_corners = 0;
  for (uint32_t v = 0; v < vertex_limit; ++v) {
    const uint32_t corner = corner_of[v];
    if (corner == none) continue;
    uint32_t at = corner, corners = 0;
    do {
      ++corners;
      at = swing_left(at);
    } while (at != corner && at != none);
    states_[v] = at == none ? kBorder : kInside;
    if (at == none)
      for (at = swing_right(corner); at != none; at = swing_right(at)) ++corners;
    ++vertex_count_;
    seen_corners += corners;
    others[v] = 0u - corners;
  }
  if (seen_corners == uint64_t{3} * (face_count_ - flat_count_)) return {};
  for (uint32_t i = 0; i < face_count_; ++i)
    if (faces_[i].mark == Face::kUnseen)
      for (const uint32_t vertex : faces_[i].vertex) ++others[vertex];
  return others;
}

// The first fan of a vertex keeps its number.
void SourceTable::separate_fans(uint32_t vertex_limit) {
  // Each vertex has a corner, so that this is room for all fans.
  states_.reset(new VertexState[size_t{vertex_limit} + size_t{3} * face_count_]);
  const std::vector<uint32_t> others = see_fans(vertex_limit);
  if (others.empty()) return;
  std::vector<bool> has_fan(vertex_limit);
  uint32_t next_number = vertex_limit;
  for (uint32_t i = 0; i < face_count_; ++i)
    for (uint32_t k = 0; k < 3; ++k) {
      if ((faces_[i].fans_seen >> k & 1) != 0 || others[faces_[i].vertex[k]] == 0) continue;
      const uint32_t corner = 4 * i + k, shared = faces_[i].vertex[k];
      const uint32_t number = has_fan[shared] ? next_number++ : shared;
      has_fan[shared] = true;
      const auto see = [&](uint32_t at) {
        face(at).fans_seen |= 1u << (at & 3);
        face(at).vertex[at & 3] = number;
      };
      uint32_t at = corner;
      do {
        see(at);
        at = swing_left(at);
      } while (at != corner && at != no_corner());
      states_[number] = at == no_corner() ? kBorder : kInside;
      if (at == no_corner())
        for (at = swing_right(corner); at != no_corner(); at = swing_right(at)) see(at);
    }
  vertex_count_ += next_number - vertex_limit;
}

}  // namespace psplit
