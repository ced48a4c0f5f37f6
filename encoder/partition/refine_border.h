// Refinement of borders (paper, section 3.6), and of balance.
#pragma once

#include "encoder/partition/cell_graph.h"

namespace psplit {

// Cells on borders change sides where fewer edges, and so fewer vertices, lie between patches after it.
// Fiduccia and Mattheyses' way: from every border cell outwards, moves are made from the best on, bad ones too,
// and those after the best moment undone. No patch rises above its limit of faces, and those above sink where
// that is cheap. A connected patch stays connected, and none becomes empty.
void refine_border(const CellGraph& graph, std::span<const uint32_t> face_limits,
                   std::vector<uint32_t>& patch_of);

}  // namespace psplit
