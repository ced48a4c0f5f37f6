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

// Copies the mesh's links to `cut`, except those of edges whose bit is set.
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

// number_attribute_vertices, of a table that is cut. Returns the number of values, and marks in `on_any_seam`
// the vertices of the mesh that are on one of the table's seams. `scratch` has room for the mesh's vertices.
template <Lanes L, typename Index>
PSPLIT_HD uint32_t number_attribute_vertices(L lanes, const Connectivity<Index>& mesh,
                                             const AttributeTable<Index>& out, View<Index> scratch,
                                             View<bool> on_any_seam) {
  const CornerTable<Index> table = mesh.table, own = out.table;
  const View<BorderEdge<Index>> border = mesh.border;
  const View<bool> closed = out.closed;
  const uint32_t vertex_count = mesh.vertex_count;
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
    // Around an inner vertex, the last seam is where the first value begins.
    scratch[v] = static_cast<Index>(corner == kNone<Index> ? seams + 1 : seams > 0 ? seams : 1);
  });
  lanes.sync();
  const uint32_t count = scan_array(lanes, scratch);
  for_each_lane_item(lanes, vertex_count, [&](uint32_t v) {
    const Index middle = previous(border[v].corner());
    Index first = middle, left = own.swing_left(middle);
    for (; left != kNone<Index> && left != middle; left = own.swing_left(left)) first = left;
    uint32_t number = scratch[v];
    closed[number] = left == middle;
    Index corner = first;
    do {
      own.vertex[corner] = static_cast<Index>(number);
      const bool seam = own.opposite[previous(corner)] == kNone<Index>;
      corner = table.swing_right(corner);
      if (seam && corner != kNone<Index> && corner != first) closed[++number] = false;
    } while (corner != kNone<Index> && corner != first);
  });
  lanes.sync();
  return count;
}

// split_into_points, in two steps: first the number of points, which also fills `scratch`, then the points.
template <typename Index>
class PointSplit {
 public:
  PSPLIT_HD PointSplit(const Connectivity<Index>& mesh, View<AttributeTable<Index>> attributes,
                       View<const bool> on_seam, View<Index> scratch)
      : table_(mesh.table),
        border_(mesh.border),
        closed_(mesh.closed),
        vertex_count_(mesh.vertex_count),
        attributes_(attributes),
        on_seam_(on_seam),
        scratch_(scratch) {}

  template <Lanes L>
  PSPLIT_HD uint32_t count(L lanes) const {
    for_each_lane_item(lanes, vertex_count_, [&](uint32_t v) {
      uint32_t points = 1;
      if (on_seam_[v]) walk(v, [&](Index, bool is_new) { points += is_new ? 1 : 0; });
      scratch_[v] = static_cast<Index>(points);
    });
    lanes.sync();
    return scan_array(lanes, scratch_);
  }
  // Stores the point of each corner, and a corner of each point.
  template <Lanes L>
  PSPLIT_HD void store(L lanes, View<Index> point_at, View<Index> corner_of_point) const {
    for_each_lane_item(lanes, vertex_count_, [&](uint32_t v) {
      Index point = scratch_[v];
      bool is_first = true;
      walk(v, [&](Index corner, bool is_new) {
        if (is_new) ++point;
        point_at[corner] = point;
        if (is_new || is_first) corner_of_point[point] = corner;
        is_first = false;
      });
    });
    lanes.sync();
  }

 private:
  // walk_points of a vertex, which has a single point if it is on no seam.
  template <typename Visit>
  PSPLIT_HD void walk(uint32_t v, Visit visit) const {
    const bool on_seam = on_seam_[v];
    const View<AttributeTable<Index>> attributes = on_seam ? attributes_ : View<AttributeTable<Index>>();
    const Index leftmost = previous(border_[v].corner());
    const Index first = first_point_corner(table_, attributes, closed_[v], leftmost);
    walk_points(table_, attributes, first, visit);
  }

  CornerTable<Index> table_;
  View<BorderEdge<Index>> border_;
  View<const bool> closed_;
  uint32_t vertex_count_ = 0;
  View<AttributeTable<Index>> attributes_;
  View<const bool> on_seam_;
  View<Index> scratch_;
};

}  // namespace psplit::core
