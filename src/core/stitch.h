// The border of a patch in walking order, from its corner table: what stitch maps count along.
// src/container/stitch.h has the definition, which knows of faces and points only.
#pragma once

#include "src/core/decode_patch.h"

namespace psplit::core {

enum class BorderKind : uint8_t {
  kWalked,     // the walk is complete
  kNoWalk,     // the patch has none: its border meets itself
  kIrregular,  // an edge of the border may have a twin elsewhere in the patch: go by the definition
};

// The border's edges as successor[point]: a border edge runs from a point to its successor. Returns how many,
// or ~0 where one may have a twin elsewhere in the patch.
template <typename Index>
PSPLIT_HD size_t link_border(const Patch<Index>& patch, View<Index> successor) {
  const CornerTable<Index>& table = patch.mesh.table;
  const View<Index> point_at = patch.point_at;
  size_t edge_count = 0;
  // Across from `corner`: false where a border edge leaves its point already, or comes back along it.
  const auto link = [&](uint32_t corner) {
    const auto start = static_cast<Index>(next(corner));
    const Index a = point_at[start], b = point_at[previous(corner)];
    if (successor[a] != kNone<Index>) return false;
    successor[a] = b;
    ++edge_count;
    // Faces around `a` from here to the border's other end.
    Index at = start;
    do {
      if (point_at[previous(at)] == b) return false;
      at = table.swing_left(at);
    } while (at != kNone<Index> && at != start && point_at[at] == a);
    return true;
  };
  if (patch.corner_of_point.empty()) {
    // Points are vertices, and one edge of the border enters each that is not closed.
    for (uint32_t v = 0; v < patch.point_count; ++v)
      if (PSPLIT_UNLIKELY(!patch.mesh.closed[v]) && !link(patch.mesh.border[v].corner())) return ~size_t{0};
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
      if (!is_joined && !link(corner)) return ~size_t{0};
      at = table.swing_right(at);
    } while (at != kNone<Index> && at != first);
  }
  return edge_count;
}

// `walk` has the points of the border one loop after the other. Both arrays stay in the arena.
template <typename Index>
PSPLIT_HD Fault walk_border(const Patch<Index>& patch, Arena& arena, View<Index>& walk, BorderKind& kind) {
  View<Index> successor;
  if (!arena.take(successor, patch.point_count)) return Fault::kWorkspace;
  fill(successor, kNone<Index>);
  const size_t edge_count = link_border(patch, successor);
  kind = BorderKind::kIrregular;
  if (edge_count == ~size_t{0}) return Fault::kNone;
  if (!arena.take(walk, edge_count)) return Fault::kWorkspace;
  size_t length = 0;
  kind = BorderKind::kNoWalk;
  for (uint32_t start = 0; start < patch.point_count && length < edge_count; ++start) {
    if (successor[start] == kNone<Index>) continue;
    uint32_t at = start;
    do {
      const Index following = successor[at];
      if (following == kNone<Index>) return Fault::kNone;
      walk[length++] = static_cast<Index>(at);
      successor[at] = kNone<Index>;
      at = following;
    } while (at != start);
  }
  kind = BorderKind::kWalked;
  return Fault::kNone;
}

}  // namespace psplit::core
