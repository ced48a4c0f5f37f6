// Cuts sets of cells in two, recursively, until each set is a patch.
#pragma once

#include "encoder/partition/cell_graph.h"
#include "src/parallel.h"

namespace psplit {

// Connected cells that become the patches [first_patch, first_patch + patch_count).
struct PatchSet {
  std::vector<uint32_t> cells;
  uint32_t first_patch = 0;
  uint32_t patch_count = 1;
};

// Writes the patch of every cell of the sets. A set is cut across the longest path through it, between two
// farthest cells. The sizes of the two parts are in proportion to their patches. So all patches are connected,
// and their sizes differ by about a cell. If a set has no more cells than patches, each cell is a patch, and
// the other patches are empty.
void halve_sets(const CellGraph& graph, std::vector<PatchSet> sets, std::vector<uint32_t>& patch_of,
                const ThreadPool& pool);

}  // namespace psplit
