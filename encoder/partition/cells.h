// Cells of faces that patches are put together from: what is small enough to be decided later.
#pragma once

#include "encoder/partition/cell_graph.h"

namespace psplit {

// Joins neighbours to cells of about `members` and at most `face_limit` faces: each starts with the first cell
// that is left, and takes the neighbour that it shares most edges with, time and again.
Coarsening grow_cells(const FaceGraph& graph, uint32_t members, uint32_t face_limit);
Coarsening grow_cells(const CellGraph& graph, uint32_t members, uint32_t face_limit);

}  // namespace psplit
