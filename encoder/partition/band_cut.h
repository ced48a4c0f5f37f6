// The least cut of a small graph between a source and a sink.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace psplit {

// Boykov and Kolmogorov: An Experimental Comparison of Min-Cut/Max-Flow Algorithms for Energy Minimization in
// Vision, 2004: a tree grows from either side, and where they meet is a path to send flow along; broken
// branches look for a new parent before they are given up. Made for reuse: memory is kept.
class BandCut {
 public:
  enum class Side : uint8_t { kFree, kSource, kSink };

  void clear();
  // Nodes come in order, each with its links to others: to which, and how much may flow either way. Both ends
  // name a link. What may come from the source and go to the sink is the node's own.
  void add_link(uint32_t to, int32_t capacity) { arcs_.push_back({to, kNone, capacity}); }
  void end_node(int32_t from_source, int32_t to_sink);

  // The least cut. Afterwards nodes are on the source's side in every least cut, or on the sink's, or free: on
  // either, all alike.
  int64_t run();
  uint32_t size() const { return static_cast<uint32_t>(nodes_.size()); }
  Side side(uint32_t node) const { return nodes_[node].side; }

 private:
  static constexpr uint32_t kNone = 0xffffffffu, kTerminal = 0xfffffffeu;
  struct Arc {
    uint32_t to = 0, back = 0;
    int32_t capacity = 0;
  };
  struct Node {
    uint32_t first = 0, end = 0;       // arcs
    int32_t terminal = 0;              // what may still come from the source, or less than 0, go to the sink
    uint32_t parent = kNone;           // the arc to it; kNone of orphans
    uint32_t stamp = 0, distance = 0;  // from the terminal, as known at the time of the stamp
    Side side = Side::kFree;
    bool is_active = false;
  };

  void join_ends();
  // What may flow through an arc away from the source's tree, or towards the sink's.
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
