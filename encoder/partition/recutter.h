// Draws the border between two patches anew, within a band of cells along it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <utility>
#include <vector>

#include "encoder/partition/band_cut.h"
#include "encoder/partition/cell_graph.h"
#include "src/parallel.h"

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

  // What surrounds the band.
  struct Ring {
    uint32_t count_a = 0, count_b = 0;                    // the cells of each patch around the band
    uint32_t cell_of_a = kOutside, cell_of_b = kOutside;  // one of them, if any
    int64_t edges_now = 0;                                // of the border between the patches
  };

  Outcome recut_band(const BorderPair& pair, double band) {
    cells_.clear();
    const size_t leaving_a = widen(pair, pair.a, pair.b, band);
    count_a_ = cells_.size();
    const size_t leaving_b = widen(pair, pair.b, pair.a, band);
    if (count_a_ == 0 || count_a_ == cells_.size()) return Outcome::kUnchanged;
    const Ring ring = build_cut(pair, leaving_a, leaving_b);
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
    if (excess(now) == 0 &&
        (edges_least > ring.edges_now || (edges_least == ring.edges_now && lean(then) >= lean(now))))
      return Outcome::kUnchanged;
    if (!apply_cut(pair, ring, then, then != least_a)) return Outcome::kUnbalanced;
    d_.sizes[pair.a] = then;
    d_.sizes[pair.b] = both - then;
    return Outcome::kChanged;
  }

  // Makes the band the nodes of the cut. The first `leaving_a` cells of patch a must move to patch b, and the
  // first `leaving_b` of patch b to patch a.
  Ring build_cut(const BorderPair& pair, size_t leaving_a, size_t leaving_b) {
    Ring ring;
    cut_.clear();
    ++ring_;
    for (size_t i = 0; i < cells_.size(); ++i) {
      const bool is_in_a = i < count_a_;
      int32_t to_a = 0, to_b = 0;
      d_.graph.for_each_link(cells_[i], [&](uint32_t next, uint32_t edges) {
        const uint32_t place = place_[next];
        if (place != kOutside) {
          cut_.add_link(place, static_cast<int32_t>(edges));
          if (is_in_a && place >= count_a_) ring.edges_now += edges;
          return;
        }
        const uint32_t patch = load_shared(d_.patch_of[next]);
        if (patch != pair.a && patch != pair.b) return;
        (patch == pair.a ? to_a : to_b) += static_cast<int32_t>(edges);
        if (std::exchange(ring_mark_[next], ring_) == ring_) return;
        ++(patch == pair.a ? ring.count_a : ring.count_b);
        (patch == pair.a ? ring.cell_of_a : ring.cell_of_b) = next;
      });
      ring.edges_now += is_in_a ? to_b : to_a;
      if (i < leaving_a) to_b += kForced;
      if (i >= count_a_ && i - count_a_ < leaving_b) to_a += kForced;
      cut_.end_node(to_a, to_b);
    }
    return ring;
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
  // false if a patch is then not connected. `size_a` is the new size of patch a.
  bool apply_cut(const BorderPair& pair, const Ring& ring, int64_t size_a, bool takes_free) {
    uint32_t of_a = ring.cell_of_a, of_b = ring.cell_of_b;  // one cell of each patch, in the band or around it
    uint32_t count_then = 0;
    for (uint32_t i = 0; i < cells_.size(); ++i) {
      const bool is_in_a =
          cut_.side(i) == BandCut::Side::kSource || (takes_free && cut_.side(i) == BandCut::Side::kFree);
      store_shared(d_.patch_of[cells_[i]], is_in_a ? pair.a : pair.b);
      (is_in_a ? of_a : of_b) = cells_[i];
      count_then += is_in_a ? 1 : 0;
    }
    const int64_t size_b = d_.sizes[pair.a] + d_.sizes[pair.b] - size_a;
    if (is_connected(of_a, pair.a, count_then + ring.count_a, size_a) &&
        is_connected(of_b, pair.b, static_cast<uint32_t>(cells_.size()) - count_then + ring.count_b, size_b))
      return true;
    for (uint32_t i = 0; i < cells_.size(); ++i)
      store_shared(d_.patch_of[cells_[i]], i < count_a_ ? pair.a : pair.b);
    return false;
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
  size_t count_a_ = 0;           // of these, the cells of patch a
  size_t first_ = 0;             // where along the border the band starts
  BandCut cut_;
};

}  // namespace psplit
