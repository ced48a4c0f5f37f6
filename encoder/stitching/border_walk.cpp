#include <algorithm>

#include "encoder/stitching/stitch_map.h"

namespace psplit {
namespace {

constexpr uint32_t kNoPoint = 0xffffffffu;

// For each point, where the directed edges of all faces lead from it and come from to it, as compressed rows.
struct DirectedEdges {
  std::vector<uint32_t> first;  // point_count + 1 entries, for both directions
  std::vector<uint32_t> to, from;

  DirectedEdges(std::span<const Face> faces, uint32_t point_count)
      : first(size_t{point_count} + 1), to(faces.size() * 3), from(faces.size() * 3) {
    // A face gives each of its points one outgoing and one incoming edge, so the offsets are the same for both.
    for (const Face& face : faces)
      for (uint32_t point : face) ++first[point + 1];
    for (uint32_t point = 0; point < point_count; ++point) first[point + 1] += first[point];
    std::vector<uint32_t> next(first.begin(), first.end() - 1);
    for (const Face& face : faces)
      for (size_t i = 0; i < 3; ++i) {
        const uint32_t slot = next[face[i]]++;
        to[slot] = face[(i + 1) % 3];
        from[slot] = face[(i + 2) % 3];
      }
  }

  size_t degree(uint32_t point) const { return first[point + 1] - first[point]; }

  // Searches the shorter of the two rows. So each spoke of a hub with thousands of spokes takes one step only.
  bool has(uint32_t a, uint32_t b) const {
    const bool from_a = degree(a) <= degree(b);
    const std::vector<uint32_t>& row = from_a ? to : from;
    const uint32_t at = from_a ? a : b;
    const auto begin = row.begin() + first[at];
    const auto end = row.begin() + first[at + 1];
    return std::find(begin, end, from_a ? b : a) != end;
  }
};

}  // namespace

std::vector<uint32_t> border_walk(std::span<const Face> faces, uint32_t point_count) {
  const DirectedEdges edges(faces, point_count);
  std::vector<uint32_t> successor(point_count, kNoPoint);
  size_t border_count = 0;
  for (const Face& face : faces)
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t a = face[i], b = face[(i + 1) % 3];
      if (edges.has(b, a)) continue;
      if (successor[a] != kNoPoint) return {};
      successor[a] = b;
      ++border_count;
    }
  std::vector<uint32_t> walk;
  walk.reserve(border_count);
  for (uint32_t start = 0; start < point_count; ++start) {
    if (successor[start] == kNoPoint) continue;
    uint32_t at = start;
    do {
      const uint32_t next = successor[at];
      if (next == kNoPoint) return {};
      walk.push_back(at);
      successor[at] = kNoPoint;
      at = next;
    } while (at != start);
  }
  return walk;
}

}  // namespace psplit
