#include "encoder/partition/recut_borders.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <type_traits>
#include <utility>

#include "encoder/partition/band_cut.h"

namespace psplit {
namespace {

constexpr size_t kGrain = 1 << 14;
// A full patch counts as if it had this share of its limit as room: a cut may exchange faces.
constexpr double kLeastRoom = 0.024;
// If the minimum cut of a band is out of balance, narrower bands are tried: by this factor, and up to kTries
// bands.
constexpr double kNarrower = 0.4;
constexpr int kTries = 3;

// Additional rounds for patches above their limit.
constexpr int kBalancingRounds = 10;

// The cells of two patches that are on their common border.
struct BorderPair {
  uint32_t a = 0, b = 0;
  std::vector<uint32_t> cells;
};

// Shared by all threads. The size and the cells of a patch belong to the thread that works on a pair with that
// patch. Other threads may read the patch of its cells meanwhile: they only see that it is not in their own
// pair.
template <typename Graph>
struct Division {
  const Graph& graph;
  std::span<const uint32_t> limits;
  std::vector<uint32_t>& patch_of;
  std::vector<int64_t> sizes;  // faces of each patch
};

template <typename Graph>
class Recutter {
 public:
  explicit Recutter(Division<Graph>& division)
      : d_(division),
        reached_(division.graph.cell_count(), 0),
        ring_mark_(reached_),
        place_(division.graph.cell_count(), kOutside) {}

  // Returns whether anything has changed. Each round starts the band at another place of the border, because
  // the band may be too small for the whole border.
  bool recut(const BorderPair& pair, double band, size_t round) {
    first_ = round * pair.cells.size() / 3;
    for (int i = 0; i < kTries; ++i, band *= kNarrower) {
      const Outcome outcome = recut_band(pair, band);
      for (const uint32_t cell : cells_) place_[cell] = kOutside;
      if (outcome != Outcome::kUnbalanced) return outcome == Outcome::kChanged;
    }
    return false;
  }

  // Moves up to `faces` faces from one patch of a pair to the other, without regard to the length of the
  // border. A face stays if its patch would not be connected without it. Returns the number of moved faces.
  int64_t push(const BorderPair& pair, uint32_t from, int64_t faces) {
    const uint32_t to = pair.a == from ? pair.b : pair.a;
    cells_.clear();
    first_ = 0;
    take_nearest(pair, from, to, kTriedFaces + 2 * faces, [](int64_t, int64_t) {});
    for (const uint32_t cell : cells_) place_[cell] = kOutside;
    int64_t gone = 0;
    for (size_t i = 0; i < cells_.size() && gone < faces; ++i) {
      uint32_t left = kOutside;
      bool is_on_border = false;
      d_.graph.for_each_link(cells_[i], [&](uint32_t next, uint32_t) {
        const uint32_t patch = load_shared(d_.patch_of[next]);
        if (patch == from) left = next;
        is_on_border |= patch == to;
      });
      if (!is_on_border || left == kOutside) continue;
      store_shared(d_.patch_of[cells_[i]], to);
      if (!is_whole(left, from, d_.sizes[from] - 1)) {
        store_shared(d_.patch_of[cells_[i]], from);
        continue;
      }
      --d_.sizes[from];
      ++d_.sizes[to];
      ++gone;
    }
    return gone;
  }

 private:
  enum class Outcome { kUnchanged, kChanged, kUnbalanced };
  static constexpr uint32_t kOutside = 0xffffffffu;
  static constexpr int32_t kForced = 1 << 28;  // more than the edges of any cell
  static constexpr int64_t kTriedFaces = 50;

  // Adds cells of patch `own` to the band, those nearest to patch `other` first. If `own` is above its limit,
  // returns how many of these cells must move: the whole surplus, or so many that both patches are equally far
  // above their limits.
  size_t widen(const BorderPair& pair, uint32_t own, uint32_t other, double band) {
    const auto room = static_cast<double>(d_.limits[other] - d_.sizes[other]);
    const double least = kLeastRoom * d_.limits[other];
    const auto most = std::min<int64_t>(d_.sizes[own] / 3, static_cast<int64_t>(band * std::max(room, least)));
    const int64_t above = d_.sizes[own] - d_.limits[own], other_above = d_.sizes[other] - d_.limits[other];
    const int64_t must_go = std::min(above, (above - other_above + 1) / 2), may_go = above - other_above;
    size_t leaving = 0;
    take_nearest(pair, own, other, most, [&](int64_t faces, int64_t cell_faces) {
      leaving += faces - cell_faces < must_go && faces <= may_go ? 1 : 0;
    });
    return leaving;
  }

  // Calls visit(faces so far, faces of the cell) for each cell.
  template <typename Visit>
  void take_nearest(const BorderPair& pair, uint32_t own, uint32_t other, int64_t most, Visit visit) {
    const size_t begin = cells_.size();
    int64_t faces = 0;
    const auto take = [&](uint32_t cell) {
      const int64_t cell_faces = d_.graph.face_count(cell);
      if (place_[cell] != kOutside || faces + cell_faces > most) return;
      faces += cell_faces;
      visit(faces, cell_faces);
      place_[cell] = static_cast<uint32_t>(cells_.size());
      cells_.push_back(cell);
    };
    for (size_t n = 0; n < pair.cells.size(); ++n) {
      const uint32_t cell = pair.cells[(first_ + n) % pair.cells.size()];
      if (load_shared(d_.patch_of[cell]) != own) continue;
      bool is_on_border = false;
      d_.graph.for_each_link(
          cell, [&](uint32_t next, uint32_t) { is_on_border |= load_shared(d_.patch_of[next]) == other; });
      if (is_on_border) take(cell);
    }
    for (size_t i = begin; i < cells_.size(); ++i)
      d_.graph.for_each_link(cells_[i], [&](uint32_t next, uint32_t) {
        if (place_[next] == kOutside && load_shared(d_.patch_of[next]) == own) take(next);
      });
  }

  Outcome recut_band(const BorderPair& pair, double band) {
    cells_.clear();
    const size_t leaving_a = widen(pair, pair.a, pair.b, band);
    const size_t count_a = cells_.size();
    const size_t leaving_b = widen(pair, pair.b, pair.a, band);
    if (count_a == 0 || count_a == cells_.size()) return Outcome::kUnchanged;

    cut_.clear();
    ++ring_;
    uint32_t ring_of_a = 0, ring_of_b = 0;      // the number of cells around the band
    uint32_t of_a = kOutside, of_b = kOutside;  // one cell of each patch, in the band or around it
    int64_t edges_now = 0;
    for (size_t i = 0; i < cells_.size(); ++i) {
      const bool is_in_a = i < count_a;
      int32_t to_a = 0, to_b = 0;
      d_.graph.for_each_link(cells_[i], [&](uint32_t next, uint32_t edges) {
        const uint32_t place = place_[next];
        if (place != kOutside) {
          cut_.add_link(place, static_cast<int32_t>(edges));
          if (is_in_a && place >= count_a) edges_now += edges;
          return;
        }
        const uint32_t patch = load_shared(d_.patch_of[next]);
        if (patch != pair.a && patch != pair.b) return;
        (patch == pair.a ? to_a : to_b) += static_cast<int32_t>(edges);
        if (std::exchange(ring_mark_[next], ring_) == ring_) return;
        ++(patch == pair.a ? ring_of_a : ring_of_b);
        (patch == pair.a ? of_a : of_b) = next;
      });
      edges_now += is_in_a ? to_b : to_a;
      if (i < leaving_a) to_b += kForced;
      if (i >= count_a && i - count_a < leaving_b) to_a += kForced;
      cut_.end_node(to_a, to_b);
    }
    const int64_t edges_least = cut_.run();

    // There are two choices for patch a: the cells on its side in every minimum cut, or those plus the free
    // cells.
    int64_t least_a = d_.sizes[pair.a], most_a = least_a;
    for (uint32_t i = 0; i < cells_.size(); ++i) {
      const int64_t faces = d_.graph.face_count(cells_[i]);
      const BandCut::Side side = cut_.side(i);
      if (i < count_a && side != BandCut::Side::kSource) least_a -= faces;
      if (i >= count_a && side == BandCut::Side::kSource) least_a += faces;
      if (i < count_a && side == BandCut::Side::kSink) most_a -= faces;
      if (i >= count_a && side != BandCut::Side::kSink) most_a += faces;
    }
    const int64_t both = d_.sizes[pair.a] + d_.sizes[pair.b];
    const auto lean = [&](int64_t a) { return std::abs(2 * a - both); };
    const auto excess = [&](int64_t a) {
      const int64_t above_a = std::max<int64_t>(a - d_.limits[pair.a], 0);
      const int64_t above_b = std::max<int64_t>(both - a - d_.limits[pair.b], 0);
      return above_a * above_a + above_b * above_b;
    };
    const int64_t now = d_.sizes[pair.a];
    const int64_t then = lean(least_a) <= lean(most_a) ? least_a : most_a;
    // A narrower band may balance better if this cut exceeds the limits as much as now.
    if (excess(then) > excess(now) || (excess(now) > 0 && excess(then) == excess(now)))
      return Outcome::kUnbalanced;
    // Here the cut reduces the excess, or there is no excess.
    if (excess(now) == 0 && (edges_least > edges_now || (edges_least == edges_now && lean(then) >= lean(now))))
      return Outcome::kUnchanged;
    uint32_t count_then = 0;
    for (uint32_t i = 0; i < cells_.size(); ++i) {
      const bool is_in_a =
          cut_.side(i) == BandCut::Side::kSource || (then != least_a && cut_.side(i) == BandCut::Side::kFree);
      store_shared(d_.patch_of[cells_[i]], is_in_a ? pair.a : pair.b);
      (is_in_a ? of_a : of_b) = cells_[i];
      count_then += is_in_a ? 1 : 0;
    }
    if (!is_connected(of_a, pair.a, count_then + ring_of_a, then) ||
        !is_connected(of_b, pair.b, static_cast<uint32_t>(cells_.size()) - count_then + ring_of_b,
                      both - then)) {
      for (uint32_t i = 0; i < cells_.size(); ++i)
        store_shared(d_.patch_of[cells_[i]], i < count_a ? pair.a : pair.b);
      return Outcome::kUnbalanced;
    }
    d_.sizes[pair.a] = then;
    d_.sizes[pair.b] = both - then;
    return Outcome::kChanged;
  }

  // Whether a patch that was connected still is. It is, if its `nearby` cells in the band and around it are
  // connected. Otherwise the whole patch is searched.
  bool is_connected(uint32_t start, uint32_t patch, uint32_t nearby, int64_t faces) {
    if (start == kOutside) return false;
    walk(start, patch, [&](uint32_t next) { return place_[next] != kOutside || ring_mark_[next] == ring_; });
    return queue_.size() == nearby || is_whole(start, patch, faces);
  }

  // Whether `faces` faces of a patch, its own size, are connected to one of its cells.
  bool is_whole(uint32_t start, uint32_t patch, int64_t faces) {
    walk(start, patch, [](uint32_t) { return true; });
    for (const uint32_t cell : queue_) faces -= d_.graph.face_count(cell);
    return faces == 0;
  }

  // Collects in queue_ the cells of a patch that are reached from `start` over allowed cells.
  template <typename IsAllowed>
  void walk(uint32_t start, uint32_t patch, IsAllowed is_allowed) {
    queue_.assign(1, start);
    reached_[start] = ++walk_;
    for (size_t i = 0; i < queue_.size(); ++i)
      d_.graph.for_each_link(queue_[i], [&](uint32_t next, uint32_t) {
        if (load_shared(d_.patch_of[next]) != patch || !is_allowed(next)) return;
        if (std::exchange(reached_[next], walk_) != walk_) queue_.push_back(next);
      });
  }

  Division<Graph>& d_;
  std::vector<uint32_t> queue_, reached_, ring_mark_;
  uint32_t walk_ = 0, ring_ = 0;
  std::vector<uint32_t> place_;  // the place of each cell in the band, or kOutside
  std::vector<uint32_t> cells_;  // the band: the cells of patch a, then those of patch b
  size_t first_ = 0;             // where along the border the band starts
  BandCut cut_;
};

// The borders of active patches, in the order of their patches.
template <typename Graph>
std::vector<BorderPair> find_borders(const Graph& graph, std::span<const uint32_t> patch_of,
                                     const std::vector<bool>& is_active, const ThreadPool& pool) {
  struct Entry {
    uint32_t a, b, cell;
  };
  std::vector<std::vector<Entry>> found((graph.cell_count() + kGrain - 1) / kGrain);
  pool.for_ranges(graph.cell_count(), kGrain, [&](size_t begin, size_t end) {
    std::vector<Entry>& entries = found[begin / kGrain];
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
    for (uint32_t i = by_patch.first[patch]; i < by_patch.first[patch + 1]; ++i)
      some.push_back(all[by_patch.members[i]]);
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
void drain(Division<FaceGraph>& division, Recutter<FaceGraph>& recutter, const ThreadPool& pool) {
  const auto patch_count = static_cast<uint32_t>(division.sizes.size());
  const auto above = [&](uint32_t patch) { return division.sizes[patch] - division.limits[patch]; };
  for (int round = 0; round < kBalancingRounds; ++round) {
    std::vector<uint32_t> full;
    for (uint32_t patch = 0; patch < patch_count; ++patch)
      if (above(patch) > 0) full.push_back(patch);
    if (full.empty()) return;
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
          faces = recutter.push(*step.pair, step.from, faces);
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
  std::mutex mutex;
  std::vector<std::unique_ptr<Recutter<Graph>>> idle;
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
        std::unique_ptr<Recutter<Graph>> recutter;
        {
          const std::lock_guard lock(mutex);
          if (!idle.empty()) {
            recutter = std::move(idle.back());
            idle.pop_back();
          }
        }
        if (recutter == nullptr) recutter = std::make_unique<Recutter<Graph>>(division);
        for (size_t i = begin; i < end; ++i)
          has_changed[static_cast<size_t>(group[i] - pairs.data())] =
              recutter->recut(*group[i], options.band, static_cast<size_t>(round));
        const std::lock_guard lock(mutex);
        idle.push_back(std::move(recutter));
      });
    }
    for (size_t patch = 0; patch < patch_count; ++patch)
      is_active[patch] = division.sizes[patch] > face_limits[patch];
    if (round + 1 >= options.rounds) continue;
    for (size_t i = 0; i < pairs.size(); ++i)
      if (has_changed[i] != 0) is_active[pairs[i].a] = is_active[pairs[i].b] = true;
  }
  if constexpr (std::is_same_v<Graph, FaceGraph>)
    if (!idle.empty()) drain(division, *idle.front(), pool);  // without a recutter there are no borders
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
