#include <algorithm>
#include <bit>
#include <memory>
#include <type_traits>

#include "encoder/partition/partition_steps.h"
#include "encoder/partition/recutter.h"
#include "src/object_pool.h"

namespace psplit {
namespace {

constexpr size_t kCellGrain = 1 << 14;
// Additional rounds for patches above their limit.
constexpr int kBalancingRounds = 10;

template <typename Graph>
using Recutters = ObjectPool<Recutter<Graph>>;

template <typename Graph>
struct RecutterLease : Recutters<Graph>::Lease {
  RecutterLease(Recutters<Graph>& recutters, Division<Graph>& division)
      : Recutters<Graph>::Lease(recutters, [&] { return std::make_unique<Recutter<Graph>>(division); }) {}
};

// The borders of active patches, in the order of their patches.
template <typename Graph>
std::vector<BorderPair> find_borders(const Graph& graph, std::span<const uint32_t> patch_of,
                                     const std::vector<bool>& is_active, const ThreadPool& pool) {
  struct Entry {
    uint32_t a, b, cell;
  };
  std::vector<std::vector<Entry>> found((graph.cell_count() + kCellGrain - 1) / kCellGrain);
  pool.for_ranges(graph.cell_count(), kCellGrain, [&](size_t begin, size_t end) {
    std::vector<Entry>& entries = found[begin / kCellGrain];
    for (auto cell = static_cast<uint32_t>(begin); cell < end; ++cell) {
      const uint32_t own = patch_of[cell];
      uint32_t last = own;
      graph.for_each_link(cell, [&](uint32_t next, uint32_t) {
        const uint32_t other = patch_of[next];
        if (other == own || other == last || (!is_active[own] && !is_active[other])) return;
        last = other;
        entries.push_back({std::min(own, other), std::max(own, other), cell});
      });
    }
  });
  std::vector<uint32_t> first_patch;
  for (const auto& entries : found)
    for (const Entry& entry : entries) first_patch.push_back(entry.a);
  const Groups by_patch(first_patch, static_cast<uint32_t>(is_active.size()));
  std::vector<Entry> all;
  all.reserve(first_patch.size());
  for (const auto& entries : found) all.insert(all.end(), entries.begin(), entries.end());
  std::vector<BorderPair> pairs;
  std::vector<Entry> some;
  for (uint32_t patch = 0; patch < is_active.size(); ++patch) {
    some.clear();
    for (const uint32_t entry : by_patch.of(patch)) some.push_back(all[entry]);
    std::stable_sort(some.begin(), some.end(), [](const Entry& x, const Entry& y) { return x.b < y.b; });
    for (const Entry& entry : some) {
      if (pairs.empty() || pairs.back().a != entry.a || pairs.back().b != entry.b)
        pairs.push_back({entry.a, entry.b, {}});
      pairs.back().cells.push_back(entry.cell);
    }
  }
  return pairs;
}

// Groups of pairs. The pairs of one group share no patch.
std::vector<std::vector<const BorderPair*>> independent(const std::vector<BorderPair>& pairs,
                                                        size_t patch_count) {
  constexpr uint32_t kLast = 63;  // pairs that fit in no group wait for another round
  std::vector<uint64_t> taken(patch_count, 0);
  std::vector<std::vector<const BorderPair*>> groups;
  for (const BorderPair& pair : pairs) {
    const auto group = static_cast<uint32_t>(std::countr_one(taken[pair.a] | taken[pair.b]));
    if (group >= kLast) continue;
    taken[pair.a] |= uint64_t{1} << group;
    taken[pair.b] |= uint64_t{1} << group;
    if (group >= groups.size()) groups.resize(group + 1);
    groups[group].push_back(&pair);
  }
  return groups;
}

struct Step {
  const BorderPair* pair;
  uint32_t from;
  size_t number;  // the number of the pair
};

// The shortest sequence of steps from a patch above its limit to one with room for its whole surplus, the last
// step first. Empty if there is no such patch.
std::vector<Step> way_to_room(const Division<FaceGraph>& division, uint32_t start,
                              std::span<const BorderPair> pairs, std::span<const std::vector<size_t>> pairs_of,
                              const std::vector<bool>& is_blocked) {
  const auto above = [&](uint32_t patch) { return division.sizes[patch] - division.limits[patch]; };
  std::vector<Step> step_to(pairs_of.size(), Step{nullptr, start, 0});
  std::vector<uint32_t> queue{start};
  for (size_t i = 0; i < queue.size(); ++i)
    for (const size_t number : pairs_of[queue[i]]) {
      const BorderPair& pair = pairs[number];
      uint32_t next = pair.a == queue[i] ? pair.b : pair.a;
      if (next == start || step_to[next].pair != nullptr || is_blocked[number]) continue;
      step_to[next] = {&pair, queue[i], number};
      queue.push_back(next);
      if (-above(next) < above(start)) continue;
      std::vector<Step> way;
      for (; next != start; next = step_to[next].from) way.push_back(step_to[next]);
      return way;
    }
  return {};
}

// If the neighbours of a patch above its limit are full as well, its surplus moves from patch to patch to the
// nearest one with room.
void drain(Division<FaceGraph>& division, Recutters<FaceGraph>& recutters, const ThreadPool& pool) {
  const auto patch_count = static_cast<uint32_t>(division.sizes.size());
  const auto above = [&](uint32_t patch) { return division.sizes[patch] - division.limits[patch]; };
  for (int round = 0; round < kBalancingRounds; ++round) {
    std::vector<uint32_t> full;
    for (uint32_t patch = 0; patch < patch_count; ++patch)
      if (above(patch) > 0) full.push_back(patch);
    if (full.empty()) return;
    const RecutterLease<FaceGraph> recutter(recutters, division);
    const std::vector<BorderPair> pairs =
        find_borders(division.graph, division.patch_of, std::vector<bool>(patch_count, true), pool);
    std::vector<std::vector<size_t>> pairs_of(patch_count);
    for (size_t i = 0; i < pairs.size(); ++i) {
      pairs_of[pairs[i].a].push_back(i);
      pairs_of[pairs[i].b].push_back(i);
    }
    std::vector<bool> is_blocked(pairs.size(), false);  // no face can move across this border
    bool has_changed = false;
    for (const uint32_t start : full)
      while (above(start) > 0) {
        const std::vector<Step> way = way_to_room(division, start, pairs, pairs_of, is_blocked);
        if (way.empty()) break;
        // The last patch of the way takes faces first, which makes room in the one before it.
        int64_t faces = above(start);
        for (const Step& step : way) {
          faces = recutter->push(*step.pair, step.from, faces);
          if (faces == 0) {
            is_blocked[step.number] = true;
            break;
          }
          has_changed = true;
        }
      }
    if (!has_changed) return;
  }
}

template <typename Graph>
void recut(const Graph& graph, std::span<const uint32_t> face_limits, const RecutOptions& options,
           std::vector<uint32_t>& patch_of, const ThreadPool& pool) {
  constexpr size_t kMostPairsATask = 4, kLeastTasks = 16;
  const size_t patch_count = face_limits.size();
  Division<Graph> division{graph, face_limits, patch_of, std::vector<int64_t>(patch_count)};
  for (uint32_t cell = 0; cell < graph.cell_count(); ++cell)
    division.sizes[patch_of[cell]] += graph.face_count(cell);
  Recutters<Graph> recutters;
  std::vector<bool> is_active(patch_count, true);
  const auto is_any_active = [&] {
    return std::find(is_active.begin(), is_active.end(), true) != is_active.end();
  };
  for (int round = 0; round < options.rounds + kBalancingRounds && is_any_active(); ++round) {
    const std::vector<BorderPair> pairs = find_borders(graph, patch_of, is_active, pool);
    std::vector<uint8_t> has_changed(pairs.size(), 0);
    for (const std::vector<const BorderPair*>& group : independent(pairs, patch_count)) {
      const size_t pairs_a_task = std::clamp<size_t>(group.size() / kLeastTasks, 1, kMostPairsATask);
      pool.for_ranges(group.size(), pairs_a_task, [&](size_t begin, size_t end) {
        const RecutterLease<Graph> recutter(recutters, division);
        for (size_t i = begin; i < end; ++i)
          has_changed[static_cast<size_t>(group[i] - pairs.data())] =
              recutter->recut(*group[i], options.band, static_cast<size_t>(round));
      });
    }
    for (size_t patch = 0; patch < patch_count; ++patch)
      is_active[patch] = division.sizes[patch] > face_limits[patch];
    if (round + 1 >= options.rounds) continue;
    for (size_t i = 0; i < pairs.size(); ++i)
      if (has_changed[i] != 0) is_active[pairs[i].a] = is_active[pairs[i].b] = true;
  }
  if constexpr (std::is_same_v<Graph, FaceGraph>) drain(division, recutters, pool);
}

}  // namespace

void recut_borders(const FaceGraph& graph, std::span<const uint32_t> face_limits, const RecutOptions& options,
                   std::vector<uint32_t>& patch_of, const ThreadPool& pool) {
  recut(graph, face_limits, options, patch_of, pool);
}
void recut_borders(const CellGraph& graph, std::span<const uint32_t> face_limits, const RecutOptions& options,
                   std::vector<uint32_t>& patch_of, const ThreadPool& pool) {
  recut(graph, face_limits, options, patch_of, pool);
}

}  // namespace psplit
