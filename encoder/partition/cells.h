// Cells of faces that patches are put together from: what is small enough to be decided later.
#pragma once

#include "encoder/partition/cell_graph.h"

namespace psplit {

// The coarser cell of each cell of a graph, and how many there are.
struct Coarsening {
  std::vector<uint32_t> coarse_of;
  uint32_t count = 0;
};

// Joins each cell with the free neighbour that makes the roundest pair of at most `face_limit` faces; a cell
// without one stays alone.
Coarsening pair_cells(const CellGraph& graph, uint32_t face_limit);

}  // namespace psplit
