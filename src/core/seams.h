// Attribute seams: edges with different values of an attribute on their two sides. They turn the mesh's corner
// table into a table of the attribute, which has a vertex for each value, and they split vertices into points.
#pragma once

#include "src/core/byte_reader.h"
#include "src/core/connectivity.h"
#include "src/core/fault.h"

namespace psplit::core {

// The connectivity of an attribute. Without seams inside the mesh it shares the mesh's arrays; with the seams
// of another attribute it shares that attribute's arrays.
template <typename Index>
struct AttributeTable {
  CornerTable<Index> table;
  View<bool> closed;  // by vertex of the table: on no border and no seam
  uint32_t vertex_count = 0;
  bool has_seams = false;

  // Only a table with seams needs arrays of its own.
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

// Calls body(v) for the vertices that are marked: mostly few.
template <Lanes L, typename Body>
PSPLIT_HD void for_each_marked(L lanes, View<const bool> marks, Body body) {
  const auto count = static_cast<uint32_t>(marks.size());
  if constexpr (L::size() == 1) {
    const auto* const bytes = reinterpret_cast<const uint8_t*>(marks.data());
    for (uint32_t v = 0; v < count;) {
      if (count - v >= 8 && load_le64(bytes + v) == 0) {
        v += 8;
        continue;
      }
      if (marks[v]) body(v);
      ++v;
    }
  } else {
    for_each_lane_item(lanes, count, [&](uint32_t v) {
      if (marks[v]) body(v);
    });
  }
}

// Cuts an attribute's table open along its seams: `bits` says which of `edges` are seams. If there are any,
// `on_seam` marks the vertices of the mesh at their ends.
template <typename Index>
PSPLIT_HD Fault cut_seams(const Connectivity<Index>& mesh, View<Index> edges, View<const uint8_t> bits,
                          Arena& arena, AttributeTable<Index>& out, View<bool> on_seam) {
  const View<Index> opposite = mesh.table.opposite, vertex = mesh.table.vertex;
  out = {mesh.table, mesh.closed, mesh.vertex_count, false};
  const auto begin = [&] {
    out.has_seams = true;
    if (!out.allocate(mesh.counts.face_count, arena)) return false;
    copy<Index>(opposite, out.table.opposite);
    fill(on_seam, false);
    return true;
  };
  for (size_t i = 0; i < bits.size();) {
    // Most edges are not seams.
    if (bits.size() - i >= 8 && load_le64(bits.data() + i) == 0) {
      i += 8;
      continue;
    }
    if (bits[i] != 0) {
      if (!out.has_seams && !begin()) return Fault::kWorkspace;
      const Index corner = edges[i];
      out.table.opposite[opposite[corner]] = kNone<Index>;
      out.table.opposite[corner] = kNone<Index>;
      on_seam[vertex[next(corner)]] = true;
      on_seam[vertex[previous(corner)]] = true;
    }
    ++i;
  }
  return Fault::kNone;
}

// The corner where the value at the `leftmost` corner of a vertex begins, clockwise: at a seam of the table
// `own` or at the border, or anywhere if there are none.
template <typename Index>
PSPLIT_HD Index first_value_corner(const CornerTable<Index>& own, Index leftmost) {
  Index first = leftmost, left = own.swing_left(first);
  for (; left != kNone<Index> && left != leftmost; left = own.swing_left(left)) first = left;
  return first;
}

// Calls visit(corner, is_new) for the corners of a vertex from `first` on, clockwise. A new value begins where
// is_new is set: after a seam of the table `own`.
template <typename Index, typename Visit>
PSPLIT_HD PSPLIT_INLINE void walk_values(const CornerTable<Index>& table, const CornerTable<Index>& own,
                                         Index first, Visit visit) {
  bool is_new = false;
  Index corner = first;
  do {
    visit(corner, is_new);
    const Index edge = previous(corner), across = table.opposite[edge];
    is_new = own.opposite[edge] == kNone<Index>;
    corner = across == kNone<Index> ? across : previous(across);
  } while (corner != kNone<Index> && corner != first);
}

// Numbers the values of a table that is cut. The value at the first corner of a vertex has the vertex's number.
// The others are numbered from the number of vertices on: by vertex, and clockwise around it. `on_seam` is of
// this table. Sets the number of values of each vertex.
template <typename Index>
PSPLIT_HD void number_attribute_vertices(const Connectivity<Index>& mesh, View<const bool> on_seam,
                                         View<Index> value_counts, AttributeTable<Index>& out) {
  copy<Index>(mesh.table.vertex, out.table.vertex);
  copy<bool>(mesh.closed.first(mesh.vertex_count), out.closed);
  fill(value_counts, Index{1});
  uint32_t count = mesh.vertex_count;
  for_each_marked(SerialLanes(), on_seam, [&](uint32_t v) {
    const uint32_t before = count;
    uint32_t number = v;
    out.closed[v] = false;
    walk_values(mesh.table, out.table, first_value_corner(out.table, mesh.first_corner(static_cast<Index>(v))),
                [&](Index corner, bool is_new) {
                  if (is_new) out.closed[number = count++] = false;
                  out.table.vertex[corner] = static_cast<Index>(number);
                });
    value_counts[v] = static_cast<Index>(1 + count - before);
  });
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

// Splits the vertices wherever an attribute has another value, one thread's way. The points of a vertex are
// numbered like values first: one has the vertex's number, and the others are numbered from the number
// of vertices on. Then all get their own numbers: by vertex, and clockwise around it.
template <typename Index>
class PointNumbers {
 public:
  // If one table has all seams, points are its values: the last call of number_attribute_vertices has set
  // `point_counts`. Around a closed vertex the point at the first corner is the last one.
  PSPLIT_HD PointNumbers(const Connectivity<Index>& mesh, const AttributeTable<Index>& only,
                         View<Index> point_counts)
      : mesh_(mesh),
        numbers_(only.table.vertex),
        point_counts_(point_counts),
        count_(only.vertex_count),
        first_is_last_(true) {}
  // Otherwise. `on_seam` marks the vertices on a seam of any attribute. `numbers` has room for all corners, and
  // `point_counts` for all vertices.
  PSPLIT_HD PointNumbers(const Connectivity<Index>& mesh, View<AttributeTable<Index>> attributes,
                         View<const bool> on_seam, View<Index> numbers, View<Index> point_counts)
      : mesh_(mesh), numbers_(numbers), point_counts_(point_counts), count_(mesh.vertex_count) {
    copy<Index>(mesh.table.vertex, numbers);
    fill(point_counts, Index{1});
    for_each_marked(SerialLanes(), on_seam, [&](uint32_t v) {
      const uint32_t before = count_;
      uint32_t number = v;
      const Index first =
          first_point_corner(mesh.table, attributes, mesh.closed[v], mesh.first_corner(static_cast<Index>(v)));
      walk_points(mesh.table, attributes, first, [&](Index corner, bool is_new) {
        if (is_new) number = count_++;
        numbers[corner] = static_cast<Index>(number);
      });
      point_counts[v] = static_cast<Index>(1 + count_ - before);
    });
  }

  PSPLIT_HD uint32_t count() const { return count_; }
  // Stores the point of each corner, and a corner of each point.
  PSPLIT_HD void store(View<Index> point_at, View<Index> corner_of_point) const {
    const View<Index> point_of = corner_of_point;  // by number, until each point has its corner
    uint32_t point = 0, next_number = mesh_.vertex_count;
    for (uint32_t v = 0; v < mesh_.vertex_count; ++v) {
      const uint32_t others = point_counts_[v] - 1u;
      const uint32_t first = first_is_last_ && mesh_.closed[v] ? others : 0;
      point_of[v] = static_cast<Index>(point + first);
      for (uint32_t k = 0; k < others; ++k)
        point_of[next_number++] = static_cast<Index>(point + k + (first == 0 ? 1 : 0));
      point += 1 + others;
    }
    for (uint32_t corner = 0; corner < point_at.size(); corner += 4)
      for (uint32_t c = corner; c < corner + 3; ++c) point_at[c] = point_of[numbers_[c]];
    for (uint32_t corner = 0; corner < point_at.size(); corner += 4)
      for (uint32_t c = corner; c < corner + 3; ++c) corner_of_point[point_at[c]] = static_cast<Index>(c);
  }

 private:
  const Connectivity<Index>& mesh_;
  View<Index> numbers_;       // by corner
  View<Index> point_counts_;  // by vertex
  uint32_t count_ = 0;
  bool first_is_last_ = false;
};

}  // namespace psplit::core
