// Attribute seams: edges where an attribute has other values on either side. They turn the corner table into
// one of the attribute's own, with a vertex for each value, and split vertices into points.
#pragma once

#include "src/core/edgebreaker.h"

namespace psplit::core {

// One attribute's connectivity. Without seams inside the mesh it is the mesh's own.
template <typename Index>
struct AttributeTable {
  CornerTable<Index> table;
  View<bool> closed;  // by vertex of the table: no border, no seam
  uint32_t vertex_count = 0;
  bool has_seams = false;
};

// Reads the seams of one attribute: a bit for each edge between two faces, at the first of its faces.
template <typename Index>
PSPLIT_HD Fault decode_seams(const Connectivity<Index>& mesh, RansBits& bits, Arena& arena,
                             AttributeTable<Index>& out) {
  const View<Index> opposite = mesh.table.opposite;
  out = {mesh.table, mesh.closed, mesh.vertex_count, false};
  for (uint32_t face = 0; face < mesh.counts.face_count; ++face) {
    for (uint32_t k = 0; k < 3; ++k) {
      const auto corner = static_cast<Index>(4 * face + k);
      const Index across = opposite[corner];
      // A face that lies across two of its own edges counts for both.
      if (across == kNone<Index> || across >> 2 < face) continue;
      if (!bits.next()) continue;
      if (!out.has_seams) {
        out.has_seams = true;
        if (!arena.take(out.table.opposite, opposite.size()) ||
            !arena.take(out.table.vertex, opposite.size()) ||
            !arena.take(out.closed, size_t{3} * mesh.counts.face_count))
          return Fault::kWorkspace;
        for (size_t i = 0; i < opposite.size(); ++i) out.table.opposite[i] = opposite[i];
      }
      out.table.opposite[corner] = kNone<Index>;
      out.table.opposite[across] = kNone<Index>;
    }
  }
  return Fault::kNone;
}

// Numbers the values around each vertex: a new one after each seam, clockwise. For a vertex on a border or a
// seam the first begins there.
template <typename Index>
PSPLIT_HD Fault number_attribute_vertices(const Connectivity<Index>& mesh, AttributeTable<Index>& out) {
  if (!out.has_seams) return Fault::kNone;
  uint32_t count = 0;
  for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
    const Index leftmost = mesh.first_corner(static_cast<Index>(v));
    if (leftmost == kNone<Index>) continue;
    Index first = leftmost;
    for (;;) {
      const Index left = out.table.swing_left(first);
      if (left == kNone<Index>) break;
      first = left;
      if (first == leftmost) break;  // no seam here
    }
    out.closed[count] = out.table.swing_left(first) != kNone<Index>;
    Index corner = first;
    do {
      out.table.vertex[corner] = static_cast<Index>(count);
      const bool seam = out.table.opposite[previous(corner)] == kNone<Index>;
      corner = mesh.table.swing_right(corner);
      if (seam && corner != kNone<Index> && corner != first) out.closed[++count] = false;
    } while (corner != kNone<Index> && corner != first);
    ++count;
  }
  out.vertex_count = count;
  return Fault::kNone;
}

// Points: vertices, split wherever an attribute is. `point` is by corner; returns their number in *point_count.
template <typename Index>
PSPLIT_HD void number_points(const Connectivity<Index>& mesh, View<const AttributeTable<Index>> attributes,
                             View<Index> point, uint32_t* point_count) {
  const auto differs = [&](Index a, Index b) {
    for (size_t i = 0; i < attributes.size(); ++i)
      if (attributes[i].has_seams && attributes[i].table.vertex[a] != attributes[i].table.vertex[b])
        return true;
    return false;
  };
  uint32_t count = 0;
  for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
    const Index leftmost = mesh.first_corner(static_cast<Index>(v));
    if (leftmost == kNone<Index>) continue;
    Index first = leftmost;
    if (mesh.closed[v]) {
      // Begin at the first attribute's first seam, if there is any.
      for (size_t i = 0; i < attributes.size() && first == leftmost; ++i) {
        if (!attributes[i].has_seams) continue;
        const View<Index> value = attributes[i].table.vertex;
        Index corner = mesh.table.swing_right(leftmost);
        while (corner != leftmost && value[corner] == value[leftmost]) corner = mesh.table.swing_right(corner);
        first = corner;
      }
    }
    Index corner = first;
    for (;;) {
      point[corner] = static_cast<Index>(count);
      const Index right = mesh.table.swing_right(corner);
      if (right == kNone<Index> || right == first) break;
      if (differs(corner, right)) ++count;
      corner = right;
    }
    ++count;
  }
  *point_count = count;
}

}  // namespace psplit::core
