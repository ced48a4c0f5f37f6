// The border of a patch in walking order, from its corner table. Stitch maps name points by their place in this
// walk. The specification defines it by faces and points alone ("border walk",
// gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include "src/core/patch.h"

namespace psplit::core {

inline constexpr size_t kNoWalk = ~size_t{0};

// Stores the border edges: each runs from a point to successor[point], with the mesh on its left (the borders
// in edgebreaker.h have it on their right). Returns the
// number of edges, or kNoWalk if two of them leave one point.
template <typename Index>
PSPLIT_HD size_t link_border(const Patch<Index>& patch, View<Index> successor) {
  const CornerTable<Index>& table = patch.mesh.table;
  const View<Index> point_at = patch.point_at;
  size_t edge_count = 0;
  // Takes the edge across from `corner`, which has no face on its other side, or a face with other points.
  // Returns false if another border edge leaves the same point.
  const auto link = [&](uint32_t corner) {
    const auto start = static_cast<Index>(next(corner));
    const Index a = point_at[start], b = point_at[previous(corner)];
    // The edge is inside the mesh if some face has it in the other direction. Such a face is one of those
    // around `a`, from here to the other end of the border.
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
    // The points are the vertices, and one border edge belongs to each that is not closed.
    for (uint32_t v = 0; v < patch.point_count; ++v)
      if (PSPLIT_UNLIKELY(!patch.mesh.closed[v]) && !link(patch.mesh.border[v].corner())) return kNoWalk;
    return edge_count;
  }
  // Seams between points are borders too. Look at each edge at a vertex on a seam or on the border.
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

// `walk` gets the points of the border, one loop after the other. It is empty if there is no border, or if the
// border edges do not form loops. Its memory stays taken. A patch that is walked already takes no memory.
template <typename Index>
PSPLIT_HD Fault walk_border(const Patch<Index>& patch, Arena& arena, View<Index>& walk) {
  walk = patch.walk;
  if (patch.is_walked) return Fault::kNone;
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
