// The edges that leave vertices of many faces. A search among all edges of such a vertex for each of its faces
// would take time quadratic in their number.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace psplit {

// Each edge leaves a vertex, goes `to` another one, and has an apex: the third vertex of its face. Edges with
// both ends in common form a set. `add` and `take` touch each edge of a set a few times in all.
class HubEdges {
 public:
  static constexpr uint32_t kNone = ~uint32_t{0};

  // What a search found.
  struct Found {
    uint32_t corner = kNone;   // of the edge; kNone if there is none
    bool passed_some = false;  // whether the set has edges before it, or none that fits
  };

  // Adds an edge as the last of its set. An edge with the corner kNone counts as taken. Returns whether the set
  // had edges before, taken ones included.
  bool add(uint32_t from, uint32_t to, uint32_t corner, uint32_t apex) {
    const auto added = static_cast<uint32_t>(edges_.size());
    edges_.push_back({corner, apex, kNone, corner == kNone});
    const auto [found, is_new] = sets_.try_emplace(key(from, to));
    Set& set = found->second;
    if (is_new)
      set.begin = added;
    else
      edges_[set.last].next = added;
    set.last = added;
    if (corner == kNone) return !is_new;
    if (set.first == kNone)
      set.first = added;
    else if (set.other == kNone && apex != edges_[set.first].apex)
      set.other = added;
    return !is_new;
  }

  // Takes the first edge that is not taken and has another apex.
  Found take(uint32_t from, uint32_t to, uint32_t apex) {
    const auto found = sets_.find(key(from, to));
    if (found == sets_.end()) return {};
    Set& set = found->second;
    const bool is_first = set.first != kNone && edges_[set.first].apex != apex;
    const uint32_t taken = is_first ? set.first : set.other;
    if (taken == kNone) return {kNone, true};
    edges_[taken].is_taken = true;
    const uint32_t first_apex = edges_[set.first].apex;
    if (is_first) {
      do set.first = edges_[set.first].next;
      while (set.first != kNone && edges_[set.first].is_taken);
      // No edge between the two has another apex than the first.
      if (set.first == kNone || edges_[set.first].apex == first_apex)
        return {edges_[taken].corner, taken != set.begin};
    }
    const uint32_t skipped = edges_[set.first].apex;
    uint32_t other = is_first ? set.first : taken;
    while (other != kNone && (edges_[other].is_taken || edges_[other].apex == skipped))
      other = edges_[other].next;
    set.other = other;
    return {edges_[taken].corner, taken != set.begin};
  }

 private:
  struct Edge {
    uint32_t corner, apex, next;
    bool is_taken;
  };
  struct Set {
    uint32_t begin = kNone, last = kNone;
    uint32_t first = kNone;  // that is not taken
    uint32_t other = kNone;  // the first that is not taken and has another apex than `first`
  };

  static uint64_t key(uint32_t from, uint32_t to) { return uint64_t{from} << 32 | to; }

  std::vector<Edge> edges_;
  std::unordered_map<uint64_t, Set> sets_;
};

}  // namespace psplit
