#include "encoder/partition/cells.h"

#include <algorithm>

namespace psplit {
namespace {

template <typename Graph>
Coarsening grow(const Graph& graph, uint32_t members, uint32_t face_limit) {
  struct Candidate {
    uint32_t cell, edges;
  };
  Coarsening grown{std::vector<uint32_t>(graph.cell_count(), kNoCell), 0};
  std::vector<uint32_t> face_counts, member_counts;
  std::vector<Candidate> around;
  const auto count_edge = [&](uint32_t key, uint32_t edges) {
    for (Candidate& candidate : around)
      if (candidate.cell == key) {
        candidate.edges += edges;
        return;
      }
    around.push_back({key, edges});
  };
  for (uint32_t seed = 0; seed < graph.cell_count(); ++seed) {
    if (grown.coarse_of[seed] != kNoCell) continue;
    const uint32_t number = grown.count;
    uint32_t faces = 0, count = 0, newest = seed;
    around.clear();
    for (;;) {
      grown.coarse_of[newest] = number;
      faces += graph.face_count(newest);
      if (++count == members) break;
      graph.for_each_link(newest, [&](uint32_t next, uint32_t edges) {
        if (grown.coarse_of[next] == kNoCell) count_edge(next, edges);
      });
      size_t best = around.size();
      for (size_t i = 0; i < around.size(); ++i)
        if (faces + graph.face_count(around[i].cell) <= face_limit &&
            (best == around.size() || around[i].edges > around[best].edges))
          best = i;
      if (best == around.size()) break;
      newest = around[best].cell;
      around[best] = around.back();
      around.pop_back();
    }
    // What is left between others joins one of them.
    if (count == 1 && members > 1) {
      around.clear();
      graph.for_each_link(seed, [&](uint32_t next, uint32_t edges) {
        const uint32_t cell = grown.coarse_of[next];
        if (cell != kNoCell && cell != number && member_counts[cell] < 2 * members &&
            face_counts[cell] + faces <= face_limit)
          count_edge(cell, edges);
      });
      const auto best =
          std::max_element(around.begin(), around.end(),
                           [](const Candidate& a, const Candidate& b) { return a.edges < b.edges; });
      if (best != around.end()) {
        grown.coarse_of[seed] = best->cell;
        face_counts[best->cell] += faces;
        ++member_counts[best->cell];
        continue;
      }
    }
    face_counts.push_back(faces);
    member_counts.push_back(count);
    ++grown.count;
  }
  return grown;
}

}  // namespace

Coarsening grow_cells(const FaceGraph& graph, uint32_t members, uint32_t face_limit) {
  return grow(graph, members, face_limit);
}
Coarsening grow_cells(const CellGraph& graph, uint32_t members, uint32_t face_limit) {
  return grow(graph, members, face_limit);
}

}  // namespace psplit
