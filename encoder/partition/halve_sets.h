// Sets of cells cut in two, and again, until each set is a patch.
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

// Writes the patch of every cell of the sets. A set is cut across the longest way through it, between two
// farthest points, where the sizes are in proportion to the patches on either side; so all patches are of
// nearly one size, up to that of a cell, and connected. A set with no more cells than patches gives each cell a
// patch, and leaves patches empty.
void halve_sets(const CellGraph& graph, std::vector<PatchSet> sets, std::vector<uint32_t>& patch_of,
                const ThreadPool& pool);

}  // namespace psplit
