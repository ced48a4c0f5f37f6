// The border of a patch in walking order, from its corner table: what stitch maps count along.
// src/container/stitch.h has the definition, which knows of faces and points only.
#pragma once

#include "src/core/decode_patch.h"

namespace psplit::core {

inline constexpr size_t kNoWalk = ~size_t{0};

// The border's edges as successor[point]: a border edge runs from a point to its successor. Returns how many,
// or kNoWalk where two leave one point.
template <typename Index>
PSPLIT_HD size_t link_border(const Patch<Index>& patch, View<Index> successor) {
  const CornerTable<Index>& table = patch.mesh.table;
  const View<Index> point_at = patch.point_at;
  size_t edge_count = 0;
  // The edge across from `corner`, which has nothing, or another point, on its other side. False where another
  // border edge leaves its point.
  const auto link = [&](uint32_t corner) {
    const auto start = static_cast<Index>(next(corner));
    const Index a = point_at[start], b = point_at[previous(corner)];
    // A face elsewhere that has the edge the other way is among those around `a`, from here to the other end of
    // the border; then it is not of the border.
    Index at = start;
    do {
      if (point_at[previous(at)] == b) return true;
      at = table.swing_left(at);
    } while (at != kNone<Index> && at != start && point_at[at] == a);
    if (successor[a] != kNone<Index>) return false;
    successor[a] = b;
    ++edge_count;
    return true;
  };
  if (patch.corner_of_point.empty()) {
    // Points are vertices, and one edge of the border enters each that is not closed.
    for (uint32_t v = 0; v < patch.point_count; ++v)
      if (PSPLIT_UNLIKELY(!patch.mesh.closed[v]) && !link(patch.mesh.border[v].corner())) return kNoWalk;
    return edge_count;
  }
  // Seams between points are borders too: look at each edge that leaves a vertex on one.
  for (uint32_t v = 0; v < patch.mesh.vertex_count; ++v) {
    if (PSPLIT_LIKELY(patch.mesh.closed[v] && !patch.on_seam[v])) continue;
    const Index first = patch.mesh.first_corner(static_cast<Index>(v));
    Index at = first;
    do {
      const Index corner = previous(at), across = table.opposite[corner];
      const bool is_joined = across != kNone<Index> && point_at[previous(across)] == point_at[at] &&
                             point_at[next(across)] == point_at[next(at)];
      if (!is_joined && !link(corner)) return kNoWalk;
      at = table.swing_right(at);
    } while (at != kNone<Index> && at != first);
  }
  return edge_count;
}

// The memory that walk_border takes.
template <typename Index>
PSPLIT_HD size_t border_walk_bytes(uint64_t point_count) {
  return 2 * Arena::bytes<Index>(point_count);
}

// `walk` has the points of the border one loop after the other, or is empty where there is none. Its arrays
// stay in the arena.
template <typename Index>
PSPLIT_HD Fault walk_border(const Patch<Index>& patch, Arena& arena, View<Index>& walk) {
  walk = {};
  if (patch.mesh.table.opposite.empty()) return Fault::kNone;  // a sequential mesh
  View<Index> successor, found;
  if (!arena.take(successor, patch.point_count)) return Fault::kWorkspace;
  fill(successor, kNone<Index>);
  const size_t edge_count = link_border(patch, successor);
  if (edge_count == kNoWalk) return Fault::kNone;
  if (!arena.take(found, edge_count)) return Fault::kWorkspace;
  size_t length = 0;
  for (uint32_t start = 0; start < patch.point_count && length < edge_count; ++start) {
    if (successor[start] == kNone<Index>) continue;
    uint32_t at = start;
    do {
      const Index following = successor[at];
      if (following == kNone<Index>) return Fault::kNone;
      found[length++] = static_cast<Index>(at);
      successor[at] = kNone<Index>;
      at = following;
    } while (at != start);
  }
  walk = found;
  return Fault::kNone;
}

}  // namespace psplit::core
