#include "encoder/partition/cells.h"

#include <algorithm>
#include <numeric>

namespace psplit {
namespace {

constexpr uint32_t kStretch = 1 << 16;
// With more than this many times the wanted cells, the ends of the stretches have cut too many cells off.
constexpr double kCutOff = 1.5;

// Grows cells only from [begin, end), numbers them from 0 on, and returns their number.
template <typename Graph>
uint32_t grow_within(const Graph& graph, uint32_t begin, uint32_t end, uint32_t members, uint32_t face_limit,
                     std::vector<uint32_t>& number) {
  struct Candidate {
    uint32_t cell, edges;
  };
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
  for (uint32_t seed = begin; seed < end; ++seed) {
    if (number[seed] != kNoCell) continue;
    const auto own = static_cast<uint32_t>(face_counts.size());
    uint32_t faces = 0, count = 0, newest = seed;
    around.clear();
    for (;;) {
      number[newest] = own;
      faces += graph.face_count(newest);
      if (++count == members) break;
      graph.for_each_link(newest, [&](uint32_t next, uint32_t edges) {
        if (next >= begin && next < end && number[next] == kNoCell) count_edge(next, edges);
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
    // A single cell that is left between others joins one of them.
    if (count == 1 && members > 1) {
      around.clear();
      graph.for_each_link(seed, [&](uint32_t next, uint32_t edges) {
        if (next < begin || next >= end) return;
        const uint32_t cell = number[next];
        if (cell != kNoCell && cell != own && member_counts[cell] < 2 * members &&
            face_counts[cell] + faces <= face_limit)
          count_edge(cell, edges);
      });
      const auto best =
          std::max_element(around.begin(), around.end(),
                           [](const Candidate& a, const Candidate& b) { return a.edges < b.edges; });
      if (best != around.end()) {
        number[seed] = best->cell;
        face_counts[best->cell] += faces;
        ++member_counts[best->cell];
        continue;
      }
    }
    face_counts.push_back(faces);
    member_counts.push_back(count);
  }
  return static_cast<uint32_t>(face_counts.size());
}

template <typename Graph>
Coarsening grow(const Graph& graph, uint32_t members, uint32_t face_limit, const ThreadPool& pool) {
  const uint32_t cell_count = graph.cell_count();
  Coarsening grown{std::vector<uint32_t>(cell_count, kNoCell), 0};
  std::vector<uint32_t> first(cell_count / kStretch + 2, 0);  // the first number of each stretch
  pool.for_ranges(cell_count, kStretch, [&](size_t begin, size_t end) {
    first[begin / kStretch + 1] = grow_within(graph, static_cast<uint32_t>(begin), static_cast<uint32_t>(end),
                                              members, face_limit, grown.coarse_of);
  });
  std::partial_sum(first.begin(), first.end(), first.begin());
  grown.count = first.back();
  if (cell_count > kStretch && static_cast<double>(grown.count) * members > kCutOff * cell_count) {
    grown.coarse_of.assign(cell_count, kNoCell);
    grown.count = grow_within(graph, 0, cell_count, members, face_limit, grown.coarse_of);
    return grown;
  }
  pool.for_ranges(cell_count, kStretch, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) grown.coarse_of[i] += first[begin / kStretch];
  });
  return grown;
}

}  // namespace

Coarsening grow_cells(const FaceGraph& graph, uint32_t members, uint32_t face_limit, const ThreadPool& pool) {
  return grow(graph, members, face_limit, pool);
}
Coarsening grow_cells(const CellGraph& graph, uint32_t members, uint32_t face_limit, const ThreadPool& pool) {
  return grow(graph, members, face_limit, pool);
}

}  // namespace psplit
