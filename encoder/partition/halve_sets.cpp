#include <algorithm>
#include <functional>
#include <iterator>
#include <queue>
#include <utility>

#include "encoder/partition/partition_steps.h"
#include "src/shared_values.h"

namespace psplit {
namespace {

constexpr uint32_t kFar = 0xffffffffu;

// Two sets share neither cells nor patches, so threads may cut different sets at the same time.
class Halving {
 public:
  Halving(const CellGraph& graph, std::vector<uint32_t>& patch_of)
      : graph_(graph),
        patch_of_(patch_of),
        radius_(radii(graph)),
        from_near_(graph.cell_count()),
        from_far_(graph.cell_count()) {}

  // Before a set is cut, its cells are in its first patch. Leaves the near half in `set` and returns the far
  // half.
  PatchSet cut(PatchSet& set) {
    std::vector<uint32_t>& cells = set.cells;
    const uint32_t near_end = measure(cells, measure(cells, cells.front(), from_near_), from_near_);
    const uint32_t far_end = measure(cells, near_end, from_near_);
    measure(cells, far_end, from_far_);
    // In this order the cells of a shortest path to the near end come in the order of the path. So any first
    // part of the order is connected. The far end is the farthest cell, so it is last.
    std::sort(cells.begin(), cells.end(), [&](uint32_t a, uint32_t b) {
      const int64_t at_a = int64_t{from_near_[a]} - from_far_[a], at_b = int64_t{from_near_[b]} - from_far_[b];
      if (at_a != at_b) return at_a < at_b;
      return from_near_[a] != from_near_[b] ? from_near_[a] < from_near_[b] : a < b;
    });

    const uint64_t face_count = graph_.faces_of(cells);
    const uint32_t near_patches = set.patch_count / 2;
    const uint64_t wanted = face_count * near_patches / set.patch_count;
    size_t near_count = 1;
    for (uint64_t taken = graph_.face_counts[cells[0]]; near_count + 1 < cells.size(); ++near_count) {
      taken += graph_.face_counts[cells[near_count]];
      if (taken > wanted + graph_.face_counts[cells[near_count]] / 2) break;
    }

    PatchSet far{{}, set.first_patch + near_patches, set.patch_count - near_patches};
    const auto rest = std::span(cells).subspan(near_count);
    for (const uint32_t c : rest) store_shared(patch_of_[c], far.first_patch);
    // Cells of the far half that the near half cuts off from it become part of the near half.
    measure(rest, far_end, from_far_);
    const auto is_near = [&](uint32_t c) { return from_far_[c] == kFar; };
    for (const uint32_t c : rest)
      if (is_near(c)) store_shared(patch_of_[c], set.first_patch);
    const auto middle = std::stable_partition(rest.begin(), rest.end(), is_near);
    far.cells.assign(middle, rest.end());
    cells.resize(cells.size() - far.cells.size());
    set.patch_count = near_patches;
    return far;
  }

 private:
  // Computes the distances from a cell to the cells of its patch, and returns the farthest. `cells` must have
  // all cells that it can reach.
  uint32_t measure(std::span<const uint32_t> cells, uint32_t start, std::vector<uint32_t>& distance) {
    for (const uint32_t c : cells) distance[c] = kFar;
    distance[start] = 0;
    const uint32_t patch = load_shared(patch_of_[start]);
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front;
    front.push({0, start});
    uint32_t farthest = start;
    while (!front.empty()) {
      const auto [here, cell] = front.top();
      front.pop();
      if (here > distance[cell]) continue;
      farthest = cell;
      for (const CellGraph::Link& link : graph_.around(cell)) {
        if (load_shared(patch_of_[link.cell]) != patch) continue;
        const uint32_t there = here + radius_[cell] + radius_[link.cell];
        if (there >= distance[link.cell]) continue;
        distance[link.cell] = there;
        front.push({there, link.cell});
      }
    }
    return farthest;
  }

  using Entry = std::pair<uint32_t, uint32_t>;  // distance, cell
  const CellGraph& graph_;
  std::vector<uint32_t>& patch_of_;
  std::vector<uint32_t> radius_, from_near_, from_far_;
};

}  // namespace

void halve_sets(const CellGraph& graph, std::vector<PatchSet> sets, std::vector<uint32_t>& patch_of,
                const ThreadPool& pool) {
  for (const PatchSet& set : sets)
    for (const uint32_t c : set.cells) patch_of[c] = set.first_patch;
  Halving halving(graph, patch_of);
  while (!sets.empty()) {
    std::vector<PatchSet> cut, far;
    for (PatchSet& set : sets) {
      if (set.patch_count == 1) continue;
      if (set.cells.size() > set.patch_count)
        cut.push_back(std::move(set));
      else
        for (uint32_t i = 0; i < set.cells.size(); ++i) patch_of[set.cells[i]] = set.first_patch + i;
    }
    far.resize(cut.size());
    pool.for_each(cut.size(), [&](size_t i) { far[i] = halving.cut(cut[i]); });
    sets = std::move(cut);
    sets.insert(sets.end(), std::make_move_iterator(far.begin()), std::make_move_iterator(far.end()));
  }
}

}  // namespace psplit
