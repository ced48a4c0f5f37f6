// Draws the border between two patches anew, within a band of cells along it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "encoder/partition/band_cut.h"
#include "encoder/partition/cell_graph.h"
#include "psplit/parallel.h"
#include "src/shared_values.h"

namespace psplit {

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
  explicit Recutter(Division<Graph>& division) : d_(division), place_(division.graph.cell_count(), kOutside) {}

  // Returns whether anything has changed. Each round starts the band at another place of the border, because
  // the band may be too small for the whole border.
  bool recut(const BorderPair& pair, double band, size_t round) {
    first_ = round * pair.cells.size() / 3;
    for (int i = 0; i < kTries; ++i, band *= kNarrower) {
      const Outcome outcome = recut_band(pair, band);
      forget_places();
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
    forget_places();
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
  // A full patch counts as if it had this share of its limit as room: a cut may exchange faces.
  static constexpr double kLeastRoom = 0.024;
  // If the minimum cut of a band is out of balance, narrower bands are tried: by this factor, and up to kTries
  // bands.
  static constexpr double kNarrower = 0.4;
  static constexpr int kTries = 3;
  static constexpr uint32_t kOutside = 0xffffffffu;
  static constexpr int32_t kForced = 1 << 28;  // more than the edges of any cell
  static constexpr int64_t kTriedFaces = 50;

  // Adds cells of patch `own` to the band, those nearest to patch `other` first. If `own` is above its limit,
  // returns how many of these cells must move: the whole surplus, or as many as it takes until both patches are
  // equally far above their limits.
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

  void forget_places() {
    for (const uint32_t cell : cells_) place_[cell] = kOutside;
    for (const RingCell& around : ring_) place_[around.cell] = kOutside;
    for (const uint32_t cell : around_) place_[cell] = kOutside;
    ring_.clear();
    around_.clear();
  }

  // A cell of the pair that is next to the band.
  struct RingCell {
    uint32_t cell;
    bool is_in_a;
  };

  Outcome recut_band(const BorderPair& pair, double band) {
    cells_.clear();
    const size_t leaving_a = widen(pair, pair.a, pair.b, band);
    count_a_ = cells_.size();
    const size_t leaving_b = widen(pair, pair.b, pair.a, band);
    if (count_a_ == 0 || count_a_ == cells_.size()) return Outcome::kUnchanged;
    const int64_t edges_now = build_cut(pair, leaving_a, leaving_b);
    const int64_t edges_least = cut_.run();

    const auto [least_a, most_a] = possible_sizes(d_.sizes[pair.a]);
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
    if (!apply_cut(pair, then != least_a)) return Outcome::kUnbalanced;
    d_.sizes[pair.a] = then;
    d_.sizes[pair.b] = both - then;
    return Outcome::kChanged;
  }

  // Makes the band the nodes of the cut. The first `leaving_a` cells of patch a must move to patch b, and the
  // first `leaving_b` of patch b to patch a. Finds the ring. Returns the edges of the border as it is.
  int64_t build_cut(const BorderPair& pair, size_t leaving_a, size_t leaving_b) {
    int64_t edges_now = 0;
    cut_.clear();
    spokes_.clear();
    for (size_t i = 0; i < cells_.size(); ++i) {
      const bool is_in_a = i < count_a_;
      int32_t to_a = 0, to_b = 0;
      d_.graph.for_each_link(cells_[i], [&](uint32_t next, uint32_t edges) {
        uint32_t& place = place_[next];
        if (place < cells_.size()) {
          cut_.add_link(place, static_cast<int32_t>(edges));
          if (is_in_a && place >= count_a_) edges_now += edges;
          return;
        }
        if (place == kOutside) {
          const uint32_t patch = load_shared(d_.patch_of[next]);
          if (patch != pair.a && patch != pair.b) return;
          place = static_cast<uint32_t>(cells_.size() + ring_.size());
          ring_.push_back({next, patch == pair.a});
        }
        (ring_[place - cells_.size()].is_in_a ? to_a : to_b) += static_cast<int32_t>(edges);
        spokes_.push_back({static_cast<uint32_t>(i), place});
      });
      edges_now += is_in_a ? to_b : to_a;
      if (i < leaving_a) to_b += kForced;
      if (i >= count_a_ && i - count_a_ < leaving_b) to_a += kForced;
      cut_.end_node(to_a, to_b);
    }
    return edges_now;
  }

  // The two sizes that the cut can give patch a: with the cells that are on its side in every minimum cut, or
  // with those and the free cells.
  std::pair<int64_t, int64_t> possible_sizes(int64_t size_a) const {
    int64_t least_a = size_a, most_a = size_a;
    for (uint32_t i = 0; i < cells_.size(); ++i) {
      const int64_t faces = d_.graph.face_count(cells_[i]);
      const BandCut::Side side = cut_.side(i);
      if (i < count_a_ && side != BandCut::Side::kSource) least_a -= faces;
      if (i >= count_a_ && side == BandCut::Side::kSource) least_a += faces;
      if (i < count_a_ && side == BandCut::Side::kSink) most_a -= faces;
      if (i >= count_a_ && side != BandCut::Side::kSink) most_a += faces;
    }
    return {least_a, most_a};
  }

  // Divides the band as the cut says, its free cells to patch a if `takes_free` holds. Undoes that and returns
  // false if a patch is then not connected.
  bool apply_cut(const BorderPair& pair, bool takes_free) {
    is_in_a_.clear();
    for (uint32_t i = 0; i < cells_.size(); ++i)
      is_in_a_.push_back(cut_.side(i) == BandCut::Side::kSource ||
                         (takes_free && cut_.side(i) == BandCut::Side::kFree));
    for (const RingCell& around : ring_) is_in_a_.push_back(around.is_in_a);
    for (uint32_t i = 0; i < cells_.size(); ++i)
      store_shared(d_.patch_of[cells_[i]], is_in_a_[i] != 0 ? pair.a : pair.b);
    if (are_connected(pair)) return true;
    for (uint32_t i = 0; i < cells_.size(); ++i)
      store_shared(d_.patch_of[cells_[i]], i < count_a_ ? pair.a : pair.b);
    return false;
  }

  // Whether two patches that were connected still are: each in the band and the ring, or by ways around them.
  bool are_connected(const BorderPair& pair) {
    join_nearby();
    const auto is_connected = [&](uint8_t in_a, uint32_t patch) {
      return component_count_[in_a] == 1 || (component_count_[in_a] > 1 && join_around(in_a, patch));
    };
    return is_connected(1, pair.a) && is_connected(0, pair.b);
  }

  uint32_t root(uint32_t at) {
    while (up_[at] != at) at = up_[at] = up_[up_[at]];
    return at;
  }
  void join(uint32_t x, uint32_t y) {
    if (is_in_a_[x] != is_in_a_[y]) return;
    const uint32_t root_x = root(x), root_y = root(y);
    if (root_x == root_y) return;
    up_[std::max(root_x, root_y)] = std::min(root_x, root_y);
    --component_count_[is_in_a_[x]];
  }

  // Joins components of a patch by paths through its cells outside the band and the ring. The paths start at
  // all cells of the ring at once; each cell on them gets the place of the ring's cell from which its path
  // started. Returns whether one component is left.
  bool join_around(uint8_t in_a, uint32_t patch) {
    queue_.clear();
    for (const RingCell& cell : ring_)
      if (is_in_a_[place_[cell.cell]] == in_a) queue_.push_back(cell.cell);
    for (size_t i = 0; i < queue_.size() && component_count_[in_a] > 1; ++i) {
      const uint32_t own = place_[queue_[i]];
      d_.graph.for_each_link(queue_[i], [&](uint32_t next, uint32_t) {
        if (load_shared(d_.patch_of[next]) != patch) return;
        if (place_[next] != kOutside) return join(own, place_[next]);
        place_[next] = own;
        queue_.push_back(next);
        around_.push_back(next);
      });
    }
    return component_count_[in_a] == 1;
  }

  // Counts the components of each patch among the places of the band and the ring.
  void join_nearby() {
    component_count_ = {0, 0};
    for (const uint8_t in_a : is_in_a_) ++component_count_[in_a];
    up_.resize(is_in_a_.size());
    std::iota(up_.begin(), up_.end(), 0u);
    for (uint32_t i = 0; i < cells_.size(); ++i)
      cut_.for_each_link(i, [&](uint32_t other) {
        if (other < i) join(other, i);
      });
    for (const auto& [band, around] : spokes_) join(band, around);
    for (uint32_t k = 0; k < ring_.size(); ++k)
      d_.graph.for_each_link(ring_[k].cell, [&](uint32_t next, uint32_t) {
        const uint32_t place = place_[next];
        if (place != kOutside && place >= cells_.size()) join(place, static_cast<uint32_t>(cells_.size()) + k);
      });
  }

  // Whether `faces` faces of a patch, its own size, are connected to one of its cells.
  bool is_whole(uint32_t start, uint32_t patch, int64_t faces) {
    queue_.assign(1, start);
    reached_.resize(place_.size());
    reached_[start] = ++walk_;
    for (size_t i = 0; i < queue_.size(); ++i) {
      faces -= d_.graph.face_count(queue_[i]);
      d_.graph.for_each_link(queue_[i], [&](uint32_t next, uint32_t) {
        if (load_shared(d_.patch_of[next]) == patch && std::exchange(reached_[next], walk_) != walk_)
          queue_.push_back(next);
      });
    }
    return faces == 0;
  }

  Division<Graph>& d_;
  // The place of each cell: in the band, its index in `cells_`; in the ring, cells_.size() plus its index in
  // `ring_`; otherwise kOutside.
  std::vector<uint32_t> place_;
  std::vector<uint32_t> cells_;  // the band: the cells of patch a, then of patch b
  size_t count_a_ = 0;           // of these, the cells of patch a
  size_t first_ = 0;             // where along the border the band starts
  std::vector<RingCell> ring_;
  std::vector<std::pair<uint32_t, uint32_t>> spokes_;  // links between places of the band and of the ring
  BandCut cut_;
  std::vector<uint8_t> is_in_a_;  // of each place, after the cut
  std::vector<uint32_t> up_;      // of each place one of the same component; itself if it is the lowest
  std::array<uint32_t, 2> component_count_{};  // of patches b and a, among the places
  std::vector<uint32_t> around_;               // cells beyond the ring that have places
  std::vector<uint32_t> queue_;
  std::vector<uint32_t> reached_;  // of each cell, the last walk of is_whole that did; empty before the first
  uint32_t walk_ = 0;
};

}  // namespace psplit
