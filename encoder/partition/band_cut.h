// The minimum cut of a small graph between a source and a sink.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace psplit {

// Source: Boykov and Kolmogorov: An Experimental Comparison of Min-Cut/Max-Flow Algorithms for Energy
// Minimization in Vision, 2004. A tree grows from each terminal. When the trees meet, flow is sent along the
// path between the terminals. Branches that this breaks look for a new parent before they are given up. The
// object keeps its memory for reuse.
class BandCut {
 public:
  enum class Side : uint8_t { kFree, kSource, kSink };

  void clear();
  // Nodes are added in order: first the links of a node, each with its other end and its capacity in either
  // direction, then end_node with the node's capacities from the source and to the sink. Both ends of a link
  // must add it.
  void add_link(uint32_t to, int32_t capacity) { arcs_.push_back({to, kNone, capacity}); }
  void end_node(int32_t from_source, int32_t to_sink);

  // Returns the value of the minimum cut. Afterwards each node is on the source's side in every minimum cut, or
  // on the sink's side in every one, or free. All free nodes may be on the same side, either one.
  int64_t run();
  uint32_t size() const { return static_cast<uint32_t>(nodes_.size()); }
  Side side(uint32_t node) const { return nodes_[node].side; }
  // visit(other) for the other end of each link of a node
  template <typename Visit>
  void for_each_link(uint32_t node, Visit visit) const {
    for (uint32_t k = nodes_[node].first; k < nodes_[node].end; ++k) visit(arcs_[k].to);
  }

 private:
  static constexpr uint32_t kNone = 0xffffffffu, kTerminal = 0xfffffffeu;
  struct Arc {
    uint32_t to = 0, back = 0;
    int32_t capacity = 0;
  };
  struct Node {
    uint32_t first = 0, end = 0;       // arcs
    int32_t terminal = 0;              // the capacity left from the source; if negative, to the sink
    uint32_t parent = kNone;           // the arc to the parent; kNone for orphans
    uint32_t stamp = 0, distance = 0;  // from the terminal, as known at the time of the stamp
    Side side = Side::kFree;
    bool is_active = false;
  };

  void join_ends();
  // The capacity of an arc away from the source's tree, or towards the sink's tree.
  int32_t capacity_from(Side side, uint32_t arc) const {
    return side == Side::kSource ? arcs_[arc].capacity : arcs_[arcs_[arc].back].capacity;
  }
  void activate(uint32_t node);
  uint32_t grow();
  void augment(uint32_t bridge);
  void adopt();
  void adopt(uint32_t node);
  bool is_rooted(uint32_t node, uint32_t& distance);

  std::vector<Node> nodes_;
  std::vector<Arc> arcs_;
  std::vector<uint32_t> active_, orphans_;
  size_t next_active_ = 0;
  uint32_t stamp_ = 0;
  int64_t flow_ = 0;
};

}  // namespace psplit
