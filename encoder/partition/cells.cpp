#include <algorithm>
#include <numeric>

#include "encoder/partition/partition_steps.h"

namespace psplit {
namespace {

constexpr uint32_t kStretch = 1 << 16;
// With more than this many times the wanted cells, the ends of the stretches have cut too many cells off.
constexpr double kCutOff = 1.5;

// Grows cells from the cells [begin, end) of a graph, numbered from 0 on.
template <typename Graph>
class StretchGrower {
 public:
  StretchGrower(const Graph& graph, uint32_t begin, uint32_t end, uint32_t members, uint32_t face_limit,
                std::vector<uint32_t>& number)
      : graph_(graph), begin_(begin), end_(end), members_(members), face_limit_(face_limit), number_(number) {}

  // Returns the number of grown cells.
  uint32_t run() {
    for (uint32_t seed = begin_; seed < end_; ++seed)
      if (number_[seed] == kNoCell) grow_from(seed);
    return static_cast<uint32_t>(face_counts_.size());
  }

 private:
  struct Candidate {
    uint32_t cell, edges;
  };

  void grow_from(uint32_t seed) {
    const auto own = static_cast<uint32_t>(face_counts_.size());
    uint32_t faces = 0, count = 0, newest = seed;
    around_.clear();
    for (;;) {
      number_[newest] = own;
      faces += graph_.face_count(newest);
      if (++count == members_) break;
      graph_.for_each_link(newest, [&](uint32_t next, uint32_t edges) {
        if (next >= begin_ && next < end_ && number_[next] == kNoCell) count_edge(next, edges);
      });
      size_t best = around_.size();
      for (size_t i = 0; i < around_.size(); ++i)
        if (faces + graph_.face_count(around_[i].cell) <= face_limit_ &&
            (best == around_.size() || around_[i].edges > around_[best].edges))
          best = i;
      if (best == around_.size()) break;
      newest = around_[best].cell;
      around_[best] = around_.back();
      around_.pop_back();
    }
    if (count == 1 && members_ > 1 && joins_neighbour(seed, own, faces)) return;
    face_counts_.push_back(faces);
    member_counts_.push_back(count);
  }

  // A single cell that is left between others joins one of them, if any has room.
  bool joins_neighbour(uint32_t seed, uint32_t own, uint32_t faces) {
    around_.clear();
    graph_.for_each_link(seed, [&](uint32_t next, uint32_t edges) {
      if (next < begin_ || next >= end_) return;
      const uint32_t cell = number_[next];
      if (cell != kNoCell && cell != own && member_counts_[cell] < 2 * members_ &&
          face_counts_[cell] + faces <= face_limit_)
        count_edge(cell, edges);
    });
    const auto best =
        std::max_element(around_.begin(), around_.end(),
                         [](const Candidate& a, const Candidate& b) { return a.edges < b.edges; });
    if (best == around_.end()) return false;
    number_[seed] = best->cell;
    face_counts_[best->cell] += faces;
    ++member_counts_[best->cell];
    return true;
  }

  void count_edge(uint32_t cell, uint32_t edges) {
    for (Candidate& candidate : around_)
      if (candidate.cell == cell) {
        candidate.edges += edges;
        return;
      }
    around_.push_back({cell, edges});
  }

  const Graph& graph_;
  uint32_t begin_, end_, members_, face_limit_;
  std::vector<uint32_t>& number_;
  std::vector<uint32_t> face_counts_, member_counts_;  // of the grown cells
  std::vector<Candidate> around_;                      // the neighbours of the cell that grows
};

template <typename Graph>
Coarsening grow(const Graph& graph, uint32_t members, uint32_t face_limit, const ThreadPool& pool) {
  const uint32_t cell_count = graph.cell_count();
  Coarsening grown{std::vector<uint32_t>(cell_count, kNoCell), 0};
  std::vector<uint32_t> first(cell_count / kStretch + 2, 0);  // the first number of each stretch
  pool.for_ranges(cell_count, kStretch, [&](size_t begin, size_t end) {
    StretchGrower grower(graph, static_cast<uint32_t>(begin), static_cast<uint32_t>(end), members, face_limit,
                         grown.coarse_of);
    first[begin / kStretch + 1] = grower.run();
  });
  std::partial_sum(first.begin(), first.end(), first.begin());
  grown.count = first.back();
  if (cell_count > kStretch && static_cast<double>(grown.count) * members > kCutOff * cell_count) {
    grown.coarse_of.assign(cell_count, kNoCell);
    grown.count = StretchGrower(graph, 0, cell_count, members, face_limit, grown.coarse_of).run();
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
