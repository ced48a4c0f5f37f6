// Seams by the lanes of a warp: what seams.h does on one thread. Each lane takes faces, edges or vertices of
// its own. All functions are collective.
#pragma once

#include "src/core/seams.h"

namespace psplit::core {

// list_inner_edges.
template <Lanes L, typename Index>
PSPLIT_HD uint32_t list_inner_edges(L lanes, const CornerTable<Index>& table, View<Index> edges) {
  if constexpr (L::size() == 1) return list_inner_edges(table, edges);
  const View<Index> opposite = table.opposite;
  const auto face_count = static_cast<uint32_t>(opposite.size() / 4);
  uint32_t count = 0;
  for (uint32_t chunk = 0; chunk < face_count; chunk += L::size()) {
    const uint32_t face = chunk + lanes.rank();
    uint32_t inner = 0;  // a bit for each corner
    if (face < face_count) {
      const FaceRow<Index> across = row_of(opposite, 4 * face);
      for (uint32_t k = 0; k < 3; ++k)
        if (across.at[k] != kNone<Index> && uint32_t{across.at[k]} >> 2 > face) inner |= 1u << k;
    }
    const Scan<uint32_t> scan = exclusive_scan(lanes, bit_count(inner));
    uint32_t at = count + scan.before;
    for (uint32_t k = 0; k < 3; ++k)
      if ((inner >> k & 1) != 0) edges[at++] = static_cast<Index>(4 * face + k);
    count += scan.total;
  }
  lanes.sync();
  return count;
}

// Copies the mesh's links to `cut`, except the links of edges whose bit is set.
template <Lanes L, typename Index>
PSPLIT_HD void cut_seams(L lanes, View<Index> opposite, View<Index> edges, View<const uint8_t> bits,
                         View<Index> cut) {
  for_each_lane_item(lanes, static_cast<uint32_t>(opposite.size() / 4),
                     [&](uint32_t face) { row_of(cut, 4 * face) = row_of(opposite, 4 * face); });
  lanes.sync();
  for_each_lane_item(lanes, static_cast<uint32_t>(bits.size()), [&](uint32_t edge) {
    if (bits[edge] == 0) return;
    const Index corner = edges[edge];
    cut[opposite[corner]] = kNone<Index>;
    cut[corner] = kNone<Index>;
  });
  lanes.sync();
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

// Numbers values as VertexSplit does. Returns the number of values, and marks in `on_any_seam` the vertices of
// the mesh that are on one of the table's seams. `scratch` has room for the mesh's vertices.
template <Lanes L, typename Index>
PSPLIT_HD uint32_t number_attribute_vertices(L lanes, const Connectivity<Index>& mesh,
                                             const AttributeTable<Index>& out, View<Index> scratch,
                                             View<bool> on_any_seam) {
  const CornerTable<Index> table = mesh.table, own = out.table;
  const View<BorderEdge<Index>> border = mesh.border;
  const View<bool> closed = out.closed, mesh_closed = mesh.closed;
  const uint32_t vertex_count = mesh.vertex_count;
  for_each_lane_item(lanes, static_cast<uint32_t>(own.vertex.size() / 4),
                     [&](uint32_t face) { row_of(own.vertex, 4 * face) = row_of(table.vertex, 4 * face); });
  for_each_lane_item(lanes, vertex_count, [&](uint32_t v) {
    const Index first = previous(border[v].corner());
    uint32_t seams = 0;
    Index corner = first;
    do {
      const Index edge = previous(corner), across = table.opposite[edge];
      seams += across != own.opposite[edge] ? 1 : 0;
      corner = across == kNone<Index> ? across : previous(across);
    } while (corner != kNone<Index> && corner != first);
    if (seams > 0) on_any_seam[v] = true;
    const bool is_closed = mesh_closed[v];
    closed[v] = is_closed && seams == 0;
    // Around an inner vertex, the last seam is where the first value begins.
    scratch[v] = static_cast<Index>(is_closed && seams > 0 ? seams - 1 : seams);
  });
  lanes.sync();
  const uint32_t count = vertex_count + scan_array(lanes, scratch);
  for_each_lane_item(lanes, vertex_count, [&](uint32_t v) {
    uint32_t next_number = vertex_count + scratch[v], number = v;
    if (next_number == (v + 1 < vertex_count ? vertex_count + scratch[v + 1] : count)) return;
    walk_values(table, own, first_value_corner(own, previous(border[v].corner())),
                [&](Index corner, bool is_new) {
                  if (is_new) closed[number = next_number++] = false;
                  if (number != v) own.vertex[corner] = static_cast<Index>(number);
                });
  });
  lanes.sync();
  return count;
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

// Splits the vertices wherever an attribute has another value: first the number of points, then the points.
// They are numbered by vertex, and clockwise around it. `on_seam` marks the vertices on a seam of any
// attribute. `scratch` has room for the mesh's vertices.
template <typename Index>
class PointSplit {
 public:
  PSPLIT_HD PointSplit(const Connectivity<Index>& mesh, View<AttributeTable<Index>> attributes,
                       View<const bool> on_seam, View<Index> scratch)
      : table_(mesh.table),
        border_(mesh.border),
        closed_(mesh.closed),
        attributes_(attributes),
        on_seam_(on_seam),
        first_point_(scratch) {}

  // The number of points. Collective.
  template <Lanes L>
  PSPLIT_HD uint32_t count(L lanes) const {
    fill(lanes, first_point_, Index{1});
    for_each_marked(lanes, on_seam_, [&](uint32_t v) {
      uint32_t points = 1;
      walk(v, [&](Index, bool is_new) { points += is_new ? 1 : 0; });
      first_point_[v] = static_cast<Index>(points);
    });
    lanes.sync();
    return scan_array(lanes, first_point_);
  }
  // Stores the point of each corner, and a corner of each point, after `count`. Collective.
  template <Lanes L>
  PSPLIT_HD void store(L lanes, View<Index> point_at, View<Index> corner_of_point) const {
    const View<Index> vertex = table_.vertex, first_point = first_point_;
    for_each_lane_item(lanes, static_cast<uint32_t>(vertex.size() / 4), [&](uint32_t face) {
      const FaceRow<Index> at = row_of(vertex, 4 * face);
      row_of(point_at, 4 * face) = {{first_point[at.at[0]], first_point[at.at[1]], first_point[at.at[2]]}};
    });
    for_each_lane_item(lanes, static_cast<uint32_t>(first_point.size()),
                       [&](uint32_t v) { corner_of_point[first_point[v]] = leftmost(v); });
    lanes.sync();
    for_each_marked(lanes, on_seam_, [&](uint32_t v) {
      uint32_t point = first_point[v];
      walk(v, [&](Index corner, bool is_new) {
        if (is_new) ++point;
        point_at[corner] = static_cast<Index>(point);
        corner_of_point[point] = corner;
      });
    });
    lanes.sync();
  }

 private:
  PSPLIT_HD Index leftmost(uint32_t v) const { return previous(border_[v].corner()); }
  template <typename Visit>
  PSPLIT_HD PSPLIT_INLINE void walk(uint32_t v, Visit visit) const {
    walk_points(table_, attributes_, first_point_corner(table_, attributes_, closed_[v], leftmost(v)), visit);
  }

  CornerTable<Index> table_;
  View<BorderEdge<Index>> border_;
  View<const bool> closed_;
  View<AttributeTable<Index>> attributes_;
  View<const bool> on_seam_;
  View<Index> first_point_;  // by vertex
};

}  // namespace psplit::core
