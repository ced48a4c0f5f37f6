// The steps of a partition: faces are joined to cells, sets of cells are cut into patches, and the borders
// between patches are drawn anew.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/partition/cell_graph.h"
#include "psplit/parallel.h"

namespace psplit {

// Joins neighbours to larger cells of about `members` cells and at most `face_limit` faces. Each starts with
// the first cell that is left. Faces are joined breadth-first; cells, by most shared edges. Stretches of
// consecutive cells are processed in parallel and independently, unless that leaves too many cells because
// their neighbours are far apart.
Coarsening grow_cells(const FaceGraph& graph, uint32_t members, uint32_t face_limit, const ThreadPool& pool);
Coarsening grow_cells(const CellGraph& graph, uint32_t members, uint32_t face_limit, const ThreadPool& pool);

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

struct RecutOptions {
  int rounds = 1;
  // The width of the band along a border: the faces on each side, divided by those for which the other side has
  // room. Wider bands give shorter borders, but more of these are out of balance and must be tried again in
  // narrower bands.
  double band = 1;
};

// For each two neighbouring patches, a minimum cut (band_cut.h) divides a band of cells along their border: no
// other border inside the band is shorter. Of equally short borders the better balanced one is used. Connected
// patches stay connected. No patch grows above its limit of faces, and patches above their limit shrink. Pairs
// that share no patch are processed in parallel; the result does not depend on the number of threads.
void recut_borders(const FaceGraph& graph, std::span<const uint32_t> face_limits, const RecutOptions& options,
                   std::vector<uint32_t>& patch_of, const ThreadPool& pool);
void recut_borders(const CellGraph& graph, std::span<const uint32_t> face_limits, const RecutOptions& options,
                   std::vector<uint32_t>& patch_of, const ThreadPool& pool);

}  // namespace psplit
