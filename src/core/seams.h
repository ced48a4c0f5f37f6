// Attribute seams: edges with different values of an attribute on their two sides. They turn the mesh's corner
// table into a table of the attribute, which has a vertex for each value, and they split vertices into points.
#pragma once

#include "src/core/byte_reader.h"
#include "src/core/connectivity.h"
#include "src/core/fault.h"

namespace psplit::core {

// The connectivity of an attribute. Without seams inside the mesh it shares the arrays of the mesh.
template <typename Index>
struct AttributeTable {
  CornerTable<Index> table;
  View<bool> closed;  // by vertex of the table: on no border and no seam
  uint32_t vertex_count = 0;
  bool has_seams = false;

  // Only a table with seams has arrays of its own.
  PSPLIT_HD bool allocate(uint32_t face_count, Arena& arena) {
    return arena.take(table.opposite, uint64_t{4} * face_count) &&
           arena.take(table.vertex, uint64_t{4} * face_count) && arena.take(closed, uint64_t{3} * face_count);
  }
  // The memory that allocate takes.
  PSPLIT_HD static size_t bytes(uint32_t face_count) {
    return 2 * Arena::bytes<Index>(uint64_t{4} * face_count) + Arena::bytes<bool>(uint64_t{3} * face_count);
  }
};

// Lists the edges between two faces, in the order in which a stream has a bit for each. An edge is given by the
// corner across from it in the first of its two faces. These differ, because Edgebreaker links each new face
// only to older ones. Returns the number of edges.
// `edges` has room for one edge at each corner.
template <typename Index>
PSPLIT_HD uint32_t list_inner_edges(const CornerTable<Index>& table, View<Index> edges) {
  uint32_t count = 0;
  const auto face_count = static_cast<uint32_t>(table.opposite.size() / 4);
  for (uint32_t face = 0; face < face_count; ++face)
    for (uint32_t corner = 4 * face; corner < 4 * face + 3; ++corner) {
      const uint32_t across = table.opposite[corner];
      edges[count] = static_cast<Index>(corner);
      count += static_cast<uint32_t>(across != kNone<Index>) & static_cast<uint32_t>(across >> 2 > face);
    }
  return count;
}

// Cuts an attribute's table open along its seams: `bits` says which of `edges` are seams. If there are any,
// `on_seam` marks the vertices of the mesh at their ends.
template <typename Index>
PSPLIT_HD Fault cut_seams(const Connectivity<Index>& mesh, View<Index> edges, View<uint8_t> bits, Arena& arena,
                          AttributeTable<Index>& out, View<bool> on_seam) {
  const View<Index> opposite = mesh.table.opposite;
  out = {mesh.table, mesh.closed, mesh.vertex_count, false};
  const auto cut = [&](uint32_t corner) {
    if (!out.has_seams) {
      out.has_seams = true;
      if (!out.allocate(mesh.counts.face_count, arena)) return false;
      for (size_t i = 0; i < opposite.size(); ++i) out.table.opposite[i] = opposite[i];
      fill(on_seam, false);
    }
    out.table.opposite[opposite[corner]] = kNone<Index>;
    out.table.opposite[corner] = kNone<Index>;
    on_seam[mesh.table.vertex[next(corner)]] = true;
    on_seam[mesh.table.vertex[previous(corner)]] = true;
    return true;
  };
  for (size_t i = 0; i < bits.size();) {
    // Most edges are not seams.
    if (bits.size() - i >= 8 && load_le64(bits.data() + i) == 0) {
      i += 8;
      continue;
    }
    if (bits[i] != 0 && !cut(edges[i])) return Fault::kWorkspace;
    ++i;
  }
  return Fault::kNone;
}

// Gives each corner a number, vertex by vertex. walk(vertex) sets the numbers at the corners of a vertex on a
// seam. All corners of any other vertex get the number that whole(vertex) returns. `scratch` has room for the
// mesh's vertices.
template <typename Index, typename Walk, typename Whole>
PSPLIT_HD void number_corners(const Connectivity<Index>& mesh, View<const bool> on_seam, View<Index> scratch,
                              View<Index> number_at, Whole whole, Walk walk) {
  for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
    scratch[v] = on_seam[v] ? kNone<Index> : whole(v);
    if (on_seam[v]) walk(v);
  }
  for (uint32_t face = 0; face < mesh.counts.face_count; ++face)
    for (uint32_t corner = 4 * face; corner < 4 * face + 3; ++corner) {
      const Index number = scratch[mesh.table.vertex[corner]];
      if (number != kNone<Index>) number_at[corner] = number;
    }
}

// Numbers the values around each vertex, clockwise, with a new number after each seam. At a vertex on a seam,
// the first value begins at a seam or at the border. `scratch` has room for the mesh's vertices.
template <typename Index>
PSPLIT_HD void number_attribute_vertices(const Connectivity<Index>& mesh, View<const bool> on_seam,
                                         View<Index> scratch, AttributeTable<Index>& out) {
  uint32_t count = 0;
  const auto whole = [&](uint32_t v) {
    out.closed[count] = mesh.closed[v];
    return static_cast<Index>(count++);
  };
  const auto walk = [&](uint32_t v) {
    Index first = mesh.first_corner(static_cast<Index>(v));
    for (Index left = first; left != kNone<Index>; left = out.table.swing_left(first)) first = left;
    Index corner = first;
    out.closed[count] = false;
    do {
      out.table.vertex[corner] = static_cast<Index>(count);
      const bool seam = out.table.opposite[previous(corner)] == kNone<Index>;
      corner = mesh.table.swing_right(corner);
      if (seam && corner != kNone<Index> && corner != first) out.closed[++count] = false;
    } while (corner != kNone<Index> && corner != first);
    ++count;
  };
  number_corners(mesh, on_seam, scratch, out.table.vertex, whole, walk);
  out.vertex_count = count;
}

// The corner where the points of a vertex begin: of a closed vertex, where the value of some attribute changes,
// if it does, so that no point begins in its middle. `leftmost` is the vertex's first corner.
template <typename Index>
PSPLIT_HD Index first_point_corner(const CornerTable<Index>& table, View<AttributeTable<Index>> attributes,
                                   bool closed, Index leftmost) {
  Index first = leftmost;
  if (!closed) return first;
  for (size_t i = 0; i < attributes.size() && first == leftmost; ++i) {
    if (!attributes[i].has_seams) continue;
    const View<Index> value = attributes[i].table.vertex;
    first = table.swing_right(leftmost);
    while (first != leftmost && value[first] == value[leftmost]) first = table.swing_right(first);
  }
  return first;
}

// Calls visit(corner, is_new) for the corners of a vertex from `first` on, clockwise. A new point begins where
// is_new is set: where some attribute has another value than at the corner before.
template <typename Index, typename Visit>
PSPLIT_HD PSPLIT_INLINE void walk_points(const CornerTable<Index>& table,
                                         View<AttributeTable<Index>> attributes, Index first, Visit visit) {
  const auto differs = [&](Index a, Index b) {
    for (size_t i = 0; i < attributes.size(); ++i)
      if (attributes[i].has_seams && attributes[i].table.vertex[a] != attributes[i].table.vertex[b])
        return true;
    return false;
  };
  visit(first, false);
  for (Index corner = first;;) {
    const Index right = table.swing_right(corner);
    if (right == kNone<Index> || right == first) return;
    visit(right, differs(corner, right));
    corner = right;
  }
}

// Splits the vertices wherever an attribute has another value, and stores the resulting point of each corner.
// Returns the number of points. `on_seam` marks the vertices on a seam of any attribute.
template <typename Index>
PSPLIT_HD uint32_t split_into_points(const Connectivity<Index>& mesh, View<AttributeTable<Index>> attributes,
                                     View<const bool> on_seam, View<Index> scratch, View<Index> point) {
  uint32_t count = 0;
  const auto walk = [&](uint32_t v) {
    const Index leftmost = mesh.first_corner(static_cast<Index>(v));
    const Index first = first_point_corner(mesh.table, attributes, mesh.closed[v], leftmost);
    walk_points(mesh.table, attributes, first, [&](Index corner, bool is_new) {
      if (is_new) ++count;
      point[corner] = static_cast<Index>(count);
    });
    ++count;
  };
  number_corners(
      mesh, on_seam, scratch, point, [&](uint32_t) { return static_cast<Index>(count++); }, walk);
  return count;
}

}  // namespace psplit::core
