// The mesh that Edgebreaker decodes (edgebreaker.h): a corner table, and its border.
#pragma once

#include "src/core/corner_table.h"
#include "src/core/lanes.h"

namespace psplit::core {

// The counts in the header of a stream.
struct ConnectivityCounts {
  uint32_t face_count = 0;
  uint32_t vertex_limit = 0;  // encoded vertices, and one for each S
  uint32_t symbol_count = 0;  // at most face_count
  uint32_t split_count = 0;
};

template <typename Index>
struct TwiceAsWide;
template <>
struct TwiceAsWide<uint16_t> {
  using Type = uint32_t;
};
template <>
struct TwiceAsWide<uint32_t> {
  using Type = uint64_t;
};

// A border edge: the edge across from `corner`, which has no face on its other side. It leaves one vertex and
// runs to the next vertex of the border, `beyond`, with the mesh on its right.
//
// Both numbers share one word. A step often loads the edge that the step before stored, and a load that spans
// two stores has to wait for both.
template <typename Index>
class BorderEdge {
 public:
  BorderEdge() = default;
  PSPLIT_HD BorderEdge(uint32_t corner, uint32_t beyond) : word_(corner | static_cast<Word>(beyond) << kBits) {}
  PSPLIT_HD Index corner() const { return static_cast<Index>(word_); }
  PSPLIT_HD Index beyond() const { return static_cast<Index>(word_ >> kBits); }

 private:
  static constexpr int kBits = 8 * sizeof(Index);
  using Word = typename TwiceAsWide<Index>::Type;
  Word word_;
};

template <typename Index>
struct Connectivity {
  ConnectivityCounts counts;
  CornerTable<Index> table;
  // The border edge that leaves each vertex. A closed vertex keeps the edge that it had before it closed. A
  // vertex that was merged into another has corner kNone.
  View<BorderEdge<Index>> border;
  View<bool> closed;          // by vertex: it is not on the border
  View<Index> merged;         // the merged vertices, in order of merging
  uint32_t vertex_count = 0;  // includes merged vertices until they are dropped
  uint32_t merged_count = 0;

  // Swinging right from this corner meets all corners of the vertex. kNone for a merged vertex.
  PSPLIT_HD Index first_corner(Index vertex) const {
    const Index corner = border[vertex].corner();
    return corner == kNone<Index> ? corner : previous(corner);
  }

  // Makes vertex n part of vertex p. Swinging left from `first` meets all corners of n, and ends at the border.
  // `across` is the corner across the edge where that begins, which the caller may know.
  PSPLIT_HD void merge(uint32_t n, uint32_t p, uint32_t first, Index across) {
    Index at = static_cast<Index>(first);
    for (;;) {
      PSPLIT_CORE_CHECK(table.vertex[at] == n);
      table.vertex[at] = static_cast<Index>(p);
      if (across == kNone<Index>) break;
      at = next(across);
      across = table.opposite[next(at)];
    }
    border[p] = border[n];
    border[n] = {kNone<Index>, 0};
    merged[merged_count++] = static_cast<Index>(n);
  }

  // To be called when all faces are there. Collective.
  template <Lanes L>
  PSPLIT_HD void find_closed_vertices(L lanes) {
    for_each_lane_item(lanes, vertex_count, [&, opposite = table.opposite](uint32_t v) {
      const Index corner = border[v].corner();
      closed[v] = corner != kNone<Index> && opposite[corner] != kNone<Index>;
    });
    lanes.sync();
  }

  // Both renumber the vertices, so that each has corners, and end the use of BorderEdge::beyond. Closed
  // vertices are to be found afterwards. move_up keeps the order, and is collective. fill_holes gives the
  // numbers of merged vertices, in order of merging, to the last vertices.
  template <Lanes L>
  PSPLIT_HD void move_up(L lanes) {
    if (merged_count == 0) return;
    if constexpr (L::size() == 1)
      move_up();
    else
      move_up_together(lanes);
  }
  PSPLIT_HD void fill_holes() {
    const Connectivity mesh = *this;  // in registers
    uint32_t count = vertex_count;
    for (uint32_t i = 0; i < mesh.merged_count; ++i) {
      const Index hole = mesh.merged[i];
      BorderEdge<Index> edge = mesh.border[count - 1];
      while (edge.corner() == kNone<Index>) edge = mesh.border[--count - 1];
      const auto last = static_cast<Index>(count - 1);
      if (last < hole) continue;
      const Index start = previous(edge.corner());
      Index corner = start;
      do {
        mesh.table.vertex[corner] = hole;
        corner = mesh.table.swing_right(corner);
      } while (corner != kNone<Index> && corner != start);
      mesh.border[hole] = edge;
      mesh.border[last] = {kNone<Index>, 0};
      --count;
    }
    vertex_count = count;
  }

  PSPLIT_HD bool allocate(Arena& arena) {
    const uint64_t corners = corner_room(counts), vertices = vertex_room(counts);
    return arena.take(table.opposite, corners) && arena.take(table.vertex, corners) &&
           arena.take(border, vertices) && arena.take(closed, vertices) &&
           arena.take(merged, counts.symbol_count);
  }
  // The memory that allocate takes: `merged` is last, and may be given back.
  PSPLIT_HD static size_t bytes(const ConnectivityCounts& counts) {
    return bytes_without_merged(counts) + merged_bytes(counts);
  }
  PSPLIT_HD static size_t bytes_without_merged(const ConnectivityCounts& counts) {
    const uint64_t corners = corner_room(counts), vertices = vertex_room(counts);
    return 2 * Arena::bytes<Index>(corners) + Arena::bytes<BorderEdge<Index>>(vertices) +
           Arena::bytes<bool>(vertices);
  }
  PSPLIT_HD static size_t merged_bytes(const ConnectivityCounts& counts) {
    return Arena::bytes<Index>(counts.symbol_count);
  }

 private:
  PSPLIT_HD static uint64_t corner_room(const ConnectivityCounts& counts) {
    return uint64_t{4} * counts.face_count;
  }
  // The last symbol may bring three vertices more than the limit before the excess is found.
  PSPLIT_HD static uint64_t vertex_room(const ConnectivityCounts& counts) {
    return uint64_t{counts.vertex_limit} + 3;
  }

  PSPLIT_HD void move_up() {
    // border[v].beyond holds the new number of v.
    uint32_t count = 0;
    for (uint32_t v = 0; v < vertex_count; ++v) {
      const Index corner = border[v].corner();
      if (corner != kNone<Index>) border[count] = {corner, border[count].beyond()};
      border[v] = {border[v].corner(), static_cast<Index>(count)};
      count += corner != kNone<Index> ? 1 : 0;
    }
    for (size_t corner = 0; corner < table.vertex.size(); corner += 4)
      for (size_t k = corner; k < corner + 3; ++k) table.vertex[k] = border[table.vertex[k]].beyond();
    vertex_count = count;
  }

  // Like move_up, but by all lanes together.
  template <Lanes L>
  PSPLIT_HD void move_up_together(L lanes) {
    const View<BorderEdge<Index>> edges = border;
    const View<Index> vertex = table.vertex;
    const uint32_t old_count = vertex_count;
    uint32_t count = 0;
    for (uint32_t chunk = 0; chunk < old_count; chunk += L::size()) {
      const uint32_t v = chunk + lanes.rank();
      const Index corner = v < old_count ? edges[v].corner() : kNone<Index>;
      const uint32_t kept = lanes.ballot(corner != kNone<Index>);
      if (v < old_count) edges[v] = {corner, count + bit_count(kept & ((1u << lanes.rank()) - 1))};
      count += bit_count(kept);
    }
    lanes.sync();
    for_each_lane_item(lanes, static_cast<uint32_t>(vertex.size() / 4), [&](uint32_t face) {
      FaceRow<Index>& row = row_of(vertex, 4 * face);
      for (uint32_t k = 0; k < 3; ++k) row.at[k] = edges[row.at[k]].beyond();
    });
    // No edge moves beyond its own place.
    for (uint32_t chunk = 0; chunk < old_count; chunk += L::size()) {
      const uint32_t v = chunk + lanes.rank();
      const BorderEdge<Index> edge = v < old_count ? edges[v] : BorderEdge<Index>(kNone<Index>, 0);
      lanes.sync();
      if (edge.corner() != kNone<Index>) edges[edge.beyond()] = edge;
    }
    if (lanes.rank() == 0) vertex_count = count;
    lanes.sync();
  }
};

}  // namespace psplit::core
