// Groups faces into small cells, from which patches are made.
#pragma once

#include "encoder/partition/cell_graph.h"

namespace psplit {

// Joins neighbours to larger cells of about `members` cells and at most `face_limit` faces. Each starts with
// the first cell that is left, and repeatedly takes the neighbour with which it shares most edges. Stretches of
// consecutive cells are processed in parallel and independently, unless that leaves too many cells because
// their neighbours are far apart.
Coarsening grow_cells(const FaceGraph& graph, uint32_t members, uint32_t face_limit, const ThreadPool& pool);
Coarsening grow_cells(const CellGraph& graph, uint32_t members, uint32_t face_limit, const ThreadPool& pool);

}  // namespace psplit
