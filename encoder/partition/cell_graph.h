// The topology model (paper, section 3.3): which faces and cells are neighbours, without positions.
#pragma once

#include <algorithm>
#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "psplit/parallel.h"

namespace psplit {

inline constexpr uint32_t kNoCell = 0xffffffffu;

// The cell of the next coarser graph for each cell, and the number of coarser cells.
struct Coarsening {
  std::vector<uint32_t> coarse_of;
  uint32_t count = 0;
};

// Every face is a cell. If an edge has more than two faces, each is linked only to the next, so a fan of n
// faces makes n - 1 links.
struct FaceGraph {
  struct Extra {
    uint32_t face, other;
    auto operator<=>(const Extra&) const = default;
  };
  std::vector<std::array<uint32_t, 3>> neighbours;  // across each side; kNoCell if there is none
  // Links across edges of more than two faces that do not fit in `neighbours`: both ways, sorted. has_extra
  // says which faces have such links.
  std::vector<Extra> extra;
  std::vector<uint8_t> has_extra;  // empty if there are no such links

  uint32_t cell_count() const { return static_cast<uint32_t>(neighbours.size()); }
  uint32_t face_count(uint32_t) const { return 1; }
  // visit(cell, edges)
  template <typename Visit>
  void for_each_link(uint32_t face, Visit visit) const {
    for (const uint32_t other : neighbours[face])
      if (other != kNoCell) visit(other, 1u);
    if (has_extra.empty() || has_extra[face] == 0) return;
    for (auto at = std::lower_bound(extra.begin(), extra.end(), Extra{face, 0});
         at != extra.end() && at->face == face; ++at)
      visit(at->other, 1u);
  }

  // `links` has each link both ways, in any order.
  void set_extra(std::vector<Extra> links);
};

FaceGraph face_graph(std::span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count,
                     const ThreadPool& pool);

// Cells are connected sets of faces. A link has the number of mesh edges that two cells share.
struct CellGraph {
  struct Link {
    uint32_t cell = 0;
    uint32_t edges = 0;
    auto operator<=>(const Link&) const = default;
  };
  std::vector<uint64_t> first;  // links of cell c are [first[c], first[c + 1])
  std::vector<Link> links;
  std::vector<uint32_t> face_counts;  // of each cell

  uint32_t cell_count() const { return static_cast<uint32_t>(face_counts.size()); }
  uint32_t face_count(uint32_t cell) const { return face_counts[cell]; }
  uint64_t faces_of(std::span<const uint32_t> cells) const {
    uint64_t sum = 0;
    for (const uint32_t cell : cells) sum += face_counts[cell];
    return sum;
  }
  std::span<const Link> around(uint32_t cell) const {
    return std::span(links).subspan(first[cell], first[cell + 1] - first[cell]);
  }
  template <typename Visit>
  void for_each_link(uint32_t cell, Visit visit) const {
    for (const Link& link : around(cell)) visit(link.cell, link.edges);
  }
};

// Joins cells with equal numbers. A number may have no cells.
CellGraph contract(const FaceGraph& graph, const Coarsening& coarsening, const ThreadPool& pool);
CellGraph contract(const CellGraph& graph, const Coarsening& coarsening, const ThreadPool& pool);

// The distance from the middle of each cell to its border, in eighths of that distance in a face. A step from
// cell to cell is as long as their two radii together.
std::vector<uint32_t> radii(const CellGraph& graph);

// The members of group g are members[first[g], first[g + 1]), in ascending order.
struct Groups {
  std::vector<uint32_t> first, members;

  Groups(std::span<const uint32_t> group_of, uint32_t group_count);

  std::span<const uint32_t> of(size_t group) const {
    return std::span(members).subspan(first[group], first[group + 1] - first[group]);
  }
};

}  // namespace psplit
