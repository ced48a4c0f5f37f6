// Cells of faces that patches are put together from: what is small enough to be decided later.
#pragma once

#include "encoder/partition/cell_graph.h"

namespace psplit {

// Joins neighbours to cells of about `members` and at most `face_limit` faces: each starts with the first cell
// that is left, and takes the neighbour that it shares most edges with, time and again. Stretches of the order
// of cells are done at once, each for itself, unless its neighbours are all over the place.
Coarsening grow_cells(const FaceGraph& graph, uint32_t members, uint32_t face_limit, const ThreadPool& pool);
Coarsening grow_cells(const CellGraph& graph, uint32_t members, uint32_t face_limit, const ThreadPool& pool);

}  // namespace psplit
