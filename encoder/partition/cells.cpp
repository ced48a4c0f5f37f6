#include "encoder/partition/cells.h"

namespace psplit {

Coarsening pair_cells(const CellGraph& graph, uint32_t face_limit) {
  std::vector<uint32_t> border(graph.cell_count());
  for (uint32_t cell = 0; cell < graph.cell_count(); ++cell)
    for (const CellGraph::Link& link : graph.around(cell)) border[cell] += link.edges;

  Coarsening pairs{std::vector<uint32_t>(graph.cell_count(), kNoCell), 0};
  for (uint32_t cell = 0; cell < graph.cell_count(); ++cell) {
    if (pairs.coarse_of[cell] != kNoCell) continue;
    uint32_t mate = cell;
    double roundest = 0;
    for (const CellGraph::Link& link : graph.around(cell)) {
      const uint32_t faces = graph.face_counts[cell] + graph.face_counts[link.cell];
      if (pairs.coarse_of[link.cell] != kNoCell || faces > face_limit) continue;
      // A closed pair has no border left: hence the 1.
      const double around_both = 1.0 + border[cell] + border[link.cell] - 2.0 * link.edges;
      const double roundness = faces / (around_both * around_both);
      if (roundness <= roundest) continue;
      roundest = roundness;
      mate = link.cell;
    }
    pairs.coarse_of[cell] = pairs.coarse_of[mate] = pairs.count++;
  }
  return pairs;
}

}  // namespace psplit
