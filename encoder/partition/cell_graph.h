// The topology model (paper, section 3.3): positions dropped, only who borders on whom.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "src/parallel.h"

namespace psplit {

inline constexpr uint32_t kNoCell = 0xffffffffu;

// Cells are connected sets of faces, down to single ones; links say how many mesh edges two cells share.
struct CellGraph {
  struct Link {
    uint32_t cell = 0;
    uint32_t edges = 0;
  };
  std::vector<uint32_t> first;  // links of cell c are [first[c], first[c + 1])
  std::vector<Link> links;
  std::vector<uint32_t> face_counts;  // of each cell

  uint32_t cell_count() const { return static_cast<uint32_t>(face_counts.size()); }
  std::span<const Link> around(uint32_t cell) const {
    return std::span(links).subspan(first[cell], first[cell + 1] - first[cell]);
  }
};

// Every face a cell. Where an edge has more than two faces, each is linked to the next only, so that a fan of n
// faces makes n links. Two faces of several common edges have as many links.
CellGraph face_graph(std::span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count,
                     const ThreadPool& pool);

// Joins cells of equal number in `coarse_of`, all below coarse_count. A number may be without cells.
CellGraph contract(const CellGraph& graph, std::span<const uint32_t> coarse_of, uint32_t coarse_count);

// How far it is from the middle of each cell to its border, in eighths of what it is in a face: a step from
// cell to cell is as long as their two radii.
std::vector<uint32_t> radii(const CellGraph& graph);

}  // namespace psplit
