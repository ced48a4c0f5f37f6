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

// Cuts an attribute's table open along its seams: `bits` says which of `edges` are seams. Marks the vertices of
// the mesh at their ends in `on_seam`.
template <typename Index>
PSPLIT_HD Fault cut_seams(const Connectivity<Index>& mesh, View<Index> edges, View<const uint8_t> bits,
                          Arena& arena, AttributeTable<Index>& out, View<bool> on_seam) {
  const View<Index> opposite = mesh.table.opposite, vertex = mesh.table.vertex;
  out = {mesh.table, mesh.closed, mesh.vertex_count, false};
  const auto begin = [&] {
    out.has_seams = true;
    if (!out.allocate(mesh.counts.face_count, arena)) return false;
    copy<Index>(opposite, out.table.opposite);
    return true;
  };
  // Seams are listed before they are cut, because a branch for each edge is unpredictable.
  constexpr size_t kBlock = 32;
  Index seams[kBlock];
  for (size_t start = 0; start < bits.size(); start += kBlock) {
    const size_t end = bits.size() - start < kBlock ? bits.size() : start + kBlock;
    if (end - start == kBlock) {
      uint64_t any = 0;
      for (size_t i = start; i < end; i += 8) any |= load_le64(bits.data() + i);
      if (any == 0) continue;
    }
    uint32_t count = 0;
    for (size_t i = start; i < end; ++i) {
      seams[count] = edges[i];
      count += bits[i] != 0;
    }
    if (count > 0 && !out.has_seams && !begin()) return Fault::kWorkspace;
    for (uint32_t i = 0; i < count; ++i) {
      const Index corner = seams[i];
      out.table.opposite[opposite[corner]] = kNone<Index>;
      out.table.opposite[corner] = kNone<Index>;
      on_seam[vertex[next(corner)]] = true;
      on_seam[vertex[previous(corner)]] = true;
    }
  }
  return Fault::kNone;
}

// Splits vertices at seams, one thread's way: into the values of each table that is cut, and into points, which
// differ in a value of some table. All numbers follow from one walk around each vertex.
//
// One value, or point, of a vertex has the vertex's number. The others have those from the number of vertices
// on: by vertex, and clockwise around it. Then points get their own numbers, in that order.
template <typename Index>
class VertexSplit {
 public:
  // `edges` and `changes` have room for all corners of any vertex: three for each face. `point_counts` has room
  // for all vertices.
  PSPLIT_HD VertexSplit(const Connectivity<Index>& mesh, View<Index> edges, View<uint8_t> changes,
                        View<Index> point_counts)
      : mesh_(mesh), edges_(edges), changes_(changes), point_counts_(point_counts) {}

  // Numbers the values of one or more tables with seams. `on_seam` marks the vertices on a
  // seam of any of them. `numbers` has room for all corners, and is not used for one table, whose values are
  // the points.
  PSPLIT_HD void split(AttributeTable<Index>* const* tables, uint32_t table_count, View<const bool> on_seam,
                       View<Index> numbers) {
    const View<Index> vertex = mesh_.table.vertex;
    for (uint32_t i = 0; i < table_count; ++i) {
      copy<Index>(vertex, tables[i]->table.vertex);
      copy<bool>(mesh_.closed.first(mesh_.vertex_count), tables[i]->closed);
    }
    points_are_values_ = table_count == 1;
    numbers_ = points_are_values_ ? tables[0]->table.vertex : numbers;
    if (!points_are_values_) copy<Index>(vertex, numbers_);
    fill(point_counts_, Index{1});
    count_ = mesh_.vertex_count;
    for_each_marked(SerialLanes(), on_seam, [&](uint32_t v) {
      gather_edges(v);
      uint32_t points = 1, first = 0;  // `first`: the place of the corner where points begin
      for (uint32_t i = 0; i < table_count; ++i) {
        points = split_values(v, *tables[i]);
        if (first == 0 && points > 1 && closed_) first = first_cut(*tables[i]);
      }
      point_counts_[v] = static_cast<Index>(points_are_values_ ? points : split_points(v, first));
    });
    for (uint32_t i = 0; i < table_count; ++i)
      for (uint32_t value = mesh_.vertex_count; value < tables[i]->vertex_count; ++value)
        tables[i]->closed[value] = false;
    if (points_are_values_) count_ = tables[0]->vertex_count;
  }

  // The number of points.
  PSPLIT_HD uint32_t count() const { return count_; }
  // Stores the point of each corner, and a corner of each point.
  PSPLIT_HD void store(View<Index> point_at, View<Index> corner_of_point) const {
    const View<Index> point_of = corner_of_point;  // by number, until each point has its corner
    uint32_t point = 0, next_number = mesh_.vertex_count;
    for (uint32_t v = 0; v < mesh_.vertex_count; ++v) {
      const uint32_t others = point_counts_[v] - 1u;
      // Points begin at a seam, where the value at the first corner of a closed vertex ends.
      const uint32_t first = points_are_values_ && mesh_.closed[v] ? others : 0;
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
  // Walks around a vertex, clockwise. Corner k is previous(edges_[k]); the edge is between it and the corner
  // before it, if there is one.
  PSPLIT_HD PSPLIT_INLINE void gather_edges(uint32_t v) {
    const View<Index> opposite = mesh_.table.opposite, edges = edges_;
    const View<uint8_t> changes = changes_;
    const Index first = next(mesh_.first_corner(static_cast<Index>(v)));
    closed_ = mesh_.closed[v];
    Index edge = first;
    uint32_t count = 0;
    do {
      changes[count] = 0;
      edges[count++] = edge;
      edge = opposite[next(edge)];
    } while (edge != kNone<Index> && edge != first);
    corner_count_ = count;
  }
  PSPLIT_HD uint32_t first_cut(const AttributeTable<Index>& table) const {
    uint32_t k = 1;
    while (table.table.opposite[edges_[k]] != kNone<Index>) ++k;
    return k;
  }
  // Splits a vertex into the values of a table, and returns their number.
  PSPLIT_HD PSPLIT_INLINE uint32_t split_values(uint32_t v, AttributeTable<Index>& table) {
    const View<Index> edges = edges_, opposite = table.table.opposite;
    const View<uint8_t> changes = changes_;
    const auto is_cut = [=](uint32_t k) -> uint32_t { return opposite[edges[k]] == kNone<Index> ? 1 : 0; };
    uint32_t cuts = 0;
    for (uint32_t k = 1; k < corner_count_; ++k) cuts += is_cut(k);
    // Around a closed vertex the last value is the first one, unless a seam is between them.
    const uint32_t cut_at_first = closed_ ? is_cut(0) : 0, count = cuts + (closed_ ? cut_at_first : 1);
    if (cuts + cut_at_first > 0) table.closed[v] = false;
    if (count < 2) return 1;
    changes[0] |= static_cast<uint8_t>(cut_at_first);
    number_parts(v, 0, count, table.vertex_count, table.table.vertex, [=](uint32_t k) {
      const uint32_t is_new = is_cut(k);
      changes[k] |= static_cast<uint8_t>(is_new);
      return is_new;
    });
    table.vertex_count += count - 1;
    return count;
  }
  // Splits a vertex into points, from the corner at place `first` on, and returns their number.
  PSPLIT_HD PSPLIT_INLINE uint32_t split_points(uint32_t v, uint32_t first) {
    const View<uint8_t> changes = changes_;
    uint32_t parts = 0, first_part = 0;
    for (uint32_t k = 1; k < corner_count_; ++k) {
      parts += changes[k];
      first_part = k == first ? parts : first_part;
    }
    const uint32_t count = parts + (closed_ ? changes[0] : 1);
    if (count < 2) return 1;
    number_parts(v, first_part, count, count_, numbers_, [=](uint32_t k) -> uint32_t { return changes[k]; });
    count_ += count - 1;
    return count;
  }
  // Gives numbers to the `count` parts of a vertex: its own number to part `first`, and those from next_number
  // on to the parts after it, clockwise. is_new(k) says whether corner k, not 0, begins a part.
  template <typename IsNew>
  PSPLIT_HD PSPLIT_INLINE void number_parts(uint32_t v, uint32_t first, uint32_t count, uint32_t next_number,
                                            View<Index> numbers, IsNew is_new) const {
    const View<Index> edges = edges_;
    const uint32_t corner_count = corner_count_;
    uint32_t place = first == 0 ? 0 : count - first;  // of the part, from `first` on
    for (uint32_t k = 0;;) {
      numbers[previous(edges[k])] = static_cast<Index>(place == 0 ? v : next_number + place - 1);
      if (++k == corner_count) break;
      place += is_new(k);
      place = place == count ? 0 : place;
    }
  }

  const Connectivity<Index>& mesh_;
  View<Index> edges_;
  View<uint8_t> changes_;     // by place around the vertex: whether a point begins there
  View<Index> point_counts_;  // by vertex
  View<Index> numbers_;       // by corner
  uint32_t count_ = 0, corner_count_ = 0;
  bool closed_ = false, points_are_values_ = false;
};

}  // namespace psplit::core
