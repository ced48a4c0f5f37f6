// The border of a patch in walking order, from its corner table. Stitch maps name points by their place in this
// walk. The specification defines it by faces and points alone ("border walk",
// gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include "src/core/patch.h"

namespace psplit::core {

inline constexpr size_t kNoWalk = ~size_t{0};

// Stores the border edges: each runs from a point to successor[point], with the mesh on its left (the borders
// in edgebreaker.h have it on their right). Returns the number of edges, or kNoWalk if two of them leave one
// point. Collective.
template <Lanes L, typename Index>
PSPLIT_HD size_t link_border(L lanes, const Patch<Index>& patch, View<Index> successor) {
  const CornerTable<Index> table = patch.mesh.table;
  const View<Index> point_at = patch.point_at;
  uint32_t edge_count = 0;
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
  const View<bool> closed = patch.mesh.closed;
  const View<BorderEdge<Index>> border = patch.mesh.border;
  bool is_alone = true;
  if (patch.corner_of_point.empty()) {
    // The points are the vertices, and one border edge belongs to each that is not closed. One enters each
    // vertex, so no two lanes link the same point.
    for_each_lane_item(lanes, patch.point_count, [&](uint32_t v) {
      if (PSPLIT_UNLIKELY(!closed[v])) is_alone &= link(border[v].corner());
    });
  } else {
    // Seams between points are borders too. Look at each edge at a vertex on a seam or on the border. A lane
    // links the points of its vertices only.
    const View<bool> on_seam = patch.on_seam;
    for_each_lane_item(lanes, patch.mesh.vertex_count, [&](uint32_t v) {
      if (PSPLIT_LIKELY(closed[v] && !on_seam[v]) || !is_alone) return;
      const Index first = previous(border[v].corner());
      Index at = first;
      do {
        const Index corner = previous(at), across = table.opposite[corner];
        const bool is_joined = across != kNone<Index> && point_at[previous(across)] == point_at[at] &&
                               point_at[next(across)] == point_at[next(at)];
        if (!is_joined) is_alone &= link(corner);
        at = table.swing_right(at);
      } while (at != kNone<Index> && at != first);
    });
  }
  edge_count = exclusive_scan(lanes, edge_count).total;
  lanes.sync();
  return any(lanes, !is_alone) ? kNoWalk : edge_count;
}

// The memory that walk_border takes.
template <typename Index>
PSPLIT_HD size_t border_walk_bytes(uint64_t point_count) {
  return 2 * Arena::bytes<Index>(point_count);
}

// `walk` gets the points of the border, one loop after the other. It is empty if there is no border, or if the
// border edges do not form loops. Its memory stays taken. A patch that is walked already takes no memory.
// Collective: all lanes share the patch, the arena and `walk`.
template <Lanes L, typename Index>
PSPLIT_HD Fault walk_border(L lanes, const Patch<Index>& patch, Arena& arena, View<Index>& walk) {
  View<Index> found = patch.walk;
  const auto find = [&] {
    if (patch.is_walked || patch.mesh.table.opposite.empty()) return Fault::kNone;  // or a sequential mesh
    const uint32_t point_count = patch.point_count;
    View<Index> successor;
    if (!take(lanes, arena, successor, point_count)) return Fault::kWorkspace;
    fill(lanes, successor, kNone<Index>);
    const size_t edge_count = link_border(lanes, patch, successor);
    if (edge_count == kNoWalk) return Fault::kNone;
    View<Index> points;
    if (!take(lanes, arena, points, edge_count)) return Fault::kWorkspace;
    uint32_t length = 0;
    // Appends the loop that begins at `start`, on the first lane. Returns false if it is not a loop.
    const auto follow = [&](uint32_t start) {
      uint32_t at = start;
      do {
        const Index following = successor[at];
        if (following == kNone<Index>) return false;
        points[length++] = static_cast<Index>(at);
        successor[at] = kNone<Index>;
        at = following;
      } while (at != start);
      return true;
    };
    for (uint32_t chunk = 0; chunk < point_count && length < edge_count;) {
      const uint32_t point = chunk + lanes.rank();
      const uint32_t starts = lanes.ballot(point < point_count && successor[point] != kNone<Index>);
      if (starts == 0) {
        chunk += L::size();
        continue;
      }
      lanes.sync();  // the first lane changes what others have read
      const bool is_loop = lanes.rank() != 0 || follow(chunk + trailing_zeros(starts));
      lanes.sync();
      if (any(lanes, !is_loop)) return Fault::kNone;
      length = broadcast(lanes, length, 0);
    }
    found = points;
    return Fault::kNone;
  };
  const Fault fault = find();
  lanes.sync();
  if (lanes.rank() == 0) walk = found;
  lanes.sync();
  return fault;
}
template <typename Index>
PSPLIT_HD Fault walk_border(const Patch<Index>& patch, Arena& arena, View<Index>& walk) {
  return walk_border(SerialLanes(), patch, arena, walk);
}

}  // namespace psplit::core
