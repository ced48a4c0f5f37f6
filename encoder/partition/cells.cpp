#include "encoder/partition/cells.h"

#include <functional>
#include <queue>
#include <utility>

namespace psplit {
namespace {

constexpr uint32_t kUnreached = 0xffffffffu;

}  // namespace

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

Coarsening sample_cells(const CellGraph& graph, uint32_t count) {
  using Entry = std::pair<uint32_t, uint32_t>;  // distance, cell
  std::priority_queue<Entry> farthest;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front;
  const std::vector<uint32_t> radius = radii(graph);
  std::vector<uint32_t> distance(graph.cell_count(), kUnreached);
  Coarsening samples{std::vector<uint32_t>(graph.cell_count(), kNoCell), 0};
  for (uint32_t cell = 0; cell < graph.cell_count(); ++cell) farthest.push({kUnreached, cell});
  while (!farthest.empty()) {
    const auto [away, sample] = farthest.top();
    farthest.pop();
    if (away != distance[sample]) continue;  // it has come nearer since
    if (away != kUnreached && samples.count >= count) break;
    const uint32_t number = samples.count++;
    distance[sample] = 0;
    samples.coarse_of[sample] = number;
    // The map of distances is updated where the new sample is nearer, and only there.
    front.push({0, sample});
    while (!front.empty()) {
      const auto [here, cell] = front.top();
      front.pop();
      if (here > distance[cell]) continue;
      if (cell != sample) farthest.push({here, cell});
      for (const CellGraph::Link& link : graph.around(cell)) {
        const uint32_t there = here + radius[cell] + radius[link.cell];
        if (there >= distance[link.cell]) continue;
        distance[link.cell] = there;
        samples.coarse_of[link.cell] = number;
        front.push({there, link.cell});
      }
    }
  }
  return samples;
}

}  // namespace psplit
