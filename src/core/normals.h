// Normals on an octahedral grid, predicted to be the same as the value before, or from the faces around a
// vertex. Draco bitstream specification 2.2, "geometric normal prediction".
#pragma once

#include "src/core/in_step.h"
#include "src/core/octahedral_chain.h"
#include "src/core/predicted_values.h"
#include "src/core/prediction_data.h"

namespace psplit::core {

// Each normal is predicted to be the same as the one before it. Computes one value a step. All corrections are
// in range (OctahedralChain).
template <typename Index>
class NormalSteps {
 public:
  NormalSteps() = default;
  PSPLIT_HD NormalSteps(const PredictedValues<Index, 2>& on, const OctahedralGrid& grid, bool canonicalized)
      : on_(on), chain_(grid, canonicalized) {}

  PSPLIT_HD uint32_t steps_left() const { return on_.sequence.count - i_; }
  PSPLIT_HD PSPLIT_INLINE void step() {
    const int32_t* by = on_.correction(i_);
    int32_t s = by[0], t = by[1];
    chain_.step(s, t);
    int32_t* const out = on_.at(on_.sequence.corner[i_]);
    out[0] = s, out[1] = t;
    ++i_;
  }

#if defined(PSPLIT_HAS_VECTORS)
  // Takes `count` steps of several runs at once, each in a lane of vectors. A run may be given more than once.
  static constexpr uint32_t kAtOnce = 4;
  static void step_at_once(NormalSteps* const (&runs)[kAtOnce], uint32_t count) {
    using Ints = int32_t __attribute__((vector_size(16)));
    OctahedralChain<Ints> chain;
    const int32_t* by[kAtOnce];
    const Index* corner[kAtOnce];
    for (uint32_t n = 0; n < kAtOnce; ++n) {
      chain.set(n, runs[n]->chain_);
      by[n] = runs[n]->on_.correction(runs[n]->i_);
      corner[n] = &runs[n]->on_.sequence.corner[runs[n]->i_];
    }
    for (uint32_t step = 0; step < count; ++step) {
      struct Pair {
        int32_t s, t;
      } at[kAtOnce];
      PSPLIT_UNROLL
      for (uint32_t n = 0; n < kAtOnce; ++n) copy_bytes(&at[n], by[n] + 2 * step, sizeof at[n]);
      Ints s{at[0].s, at[1].s, at[2].s, at[3].s}, t{at[0].t, at[1].t, at[2].t, at[3].t};
      chain.step(s, t);
      PSPLIT_UNROLL
      for (uint32_t n = 0; n < kAtOnce; ++n) {
        int32_t* const out = runs[n]->on_.at(corner[n][step]);
        out[0] = s[n], out[1] = t[n];
      }
    }
    NormalSteps* last = nullptr;
    for (uint32_t n = 0; n < kAtOnce; ++n) {
      if (runs[n] == last) continue;
      last = runs[n];
      last->chain_ = chain.get(n);
      last->i_ += count;
    }
  }
#endif

 private:
  PredictedValues<Index, 2> on_;
  OctahedralChain<int32_t> chain_;
  uint32_t i_ = 0;
};

template <typename Index>
PSPLIT_HD bool are_in_range(const PredictedValues<Index, 2>& on, const OctahedralGrid& grid) {
  bool are = true;
  for (uint32_t i = 0; i < 2 * on.sequence.count; ++i) are &= is_in_range(grid, on.corrections[i]);
  return are;
}

// Computes all values, also from corrections that no encoder writes.
template <typename Index>
PSPLIT_HD void correct_normals_by_difference(const PredictedValues<Index, 2>& on, const OctahedralGrid& grid,
                                             bool canonicalized) {
  Vec2 last;
  for (uint32_t i = 0; i < on.sequence.count; ++i) {
    const int32_t* by = on.correction(i);
    last = grid.correct(last, {by[0], by[1]}, canonicalized);
    int32_t* const out = on.at(on.sequence.corner[i]);
    out[0] = last.s, out[1] = last.t;
  }
}

// Takes the steps of all runs, several at once.
template <typename Index>
PSPLIT_HD void step_normals(NormalSteps<Index>* const* runs, uint32_t count) {
  using Run = NormalSteps<Index>;
#if defined(PSPLIT_HAS_VECTORS)
  Run* at[Run::kAtOnce];
  uint32_t live = 0;
  for (uint32_t next = 0;;) {
    for (; live < Run::kAtOnce && next < count; ++next)
      if (runs[next]->steps_left() > 0) at[live++] = runs[next];
    if (live < 2) return step_all<1, Run>(at, live);
    for (uint32_t n = live; n < Run::kAtOnce; ++n) at[n] = at[n - 1];
    uint32_t steps = at[0]->steps_left();
    for (uint32_t n = 1; n < live; ++n) steps = at[n]->steps_left() < steps ? at[n]->steps_left() : steps;
    Run::step_at_once(at, steps);
    const uint32_t before = live;
    live = 0;
    for (uint32_t n = 0; n < before; ++n)
      if (at[n]->steps_left() > 0) at[live++] = at[n];
  }
#else
  step_all<kInStep, Run, Run>(runs, count);
#endif
}

// The sum of the normals of all faces at a corner's vertex. The normal of a face is as long as the face is
// large.
template <typename Index>
PSPLIT_HD inline Vec3 normal_at(const CornerTable<Index>& table, const Positions<Index>& positions,
                                Index start) {
  const Vec3 center = positions.at(start);
  Vec3 sum;
  Index corner = start;
  bool leftwards = true;
  while (corner != kNone<Index>) {
    add_cross(sum, minus(positions.at(next(corner)), center), minus(positions.at(previous(corner)), center));
    corner = leftwards ? table.swing_left(corner) : table.swing_right(corner);
    if (corner == start) break;
    if (corner == kNone<Index> && leftwards) {
      leftwards = false;
      corner = table.swing_right(start);
    }
  }
  return sum;
}

// Sums the normals of all vertices in one walk over the faces: the normal of a face is equal at its three
// corners, even if sums wrap around. Returns no sums if the arena has too little memory, and on a device, where
// each lane has a fan.
template <typename Index>
PSPLIT_HD View<Vec3> sum_normals(const CornerTable<Index>& table, const Positions<Index>& positions,
                                 uint32_t vertex_count, Arena& arena) {
  View<Vec3> sums;
  if (PSPLIT_MOVES_ROWS || !arena.take(sums, vertex_count)) return {};
  fill(sums, Vec3());
  for (uint32_t corner = 0; corner < table.vertex.size(); corner += 4) {
    const FaceRow<Index> vertex = row_of(table.vertex, corner);
    const Vec3 at = positions.at(static_cast<Index>(corner));
    Vec3 normal;
    add_cross(normal, minus(positions.at(static_cast<Index>(corner + 1)), at),
              minus(positions.at(static_cast<Index>(corner + 2)), at));
    for (uint32_t k = 0; k < 3; ++k) sums[vertex.at[k]] = plus(sums[vertex.at[k]], normal);
  }
  return sums;
}

// The memory that it takes.
PSPLIT_HD constexpr size_t normal_sum_bytes(uint64_t vertex_count) { return Arena::bytes<Vec3>(vertex_count); }

// A normal that is about as long as 2^29 at most, so that a product with the grid's center fits. Returns the
// sum of its magnitudes.
PSPLIT_HD inline int64_t shorten(Vec3& normal) {
  constexpr uint64_t kBound = 1u << 29;
  constexpr uint64_t kMost = ~uint64_t{0} >> 1;
  const uint64_t x = magnitude(normal.x), y = magnitude(normal.y), z = magnitude(normal.z);
  const uint64_t length = x > kMost || y > kMost - x || z > kMost - x - y ? kMost : x + y + z;
  if (PSPLIT_LIKELY(length <= kBound)) return static_cast<int64_t>(length);
  const auto quotient = static_cast<int64_t>(length / kBound);
  normal = {normal.x / quotient, normal.y / quotient, normal.z / quotient};
  return static_cast<int64_t>(magnitude(normal.x) + magnitude(normal.y) + magnitude(normal.z));
}

// Each normal is predicted from the positions around its vertex; a flip says that it points the other way. A
// lane computes a value; the first one decodes all flips. `sums` come from sum_normals, or are empty.
// Collective.
template <Lanes L, typename Index>
PSPLIT_HD void predict_from_geometry(L lanes, const PredictedValues<Index, 2>& on,
                                     const Positions<Index>& positions, View<const Vec3> sums,
                                     PredictionData& data) {
  const bool canonicalized = data.transform == Transform::kOctahedronCanonicalized;
  const uint32_t count = on.sequence.count;
  for (uint32_t first = 0; first < count; first += L::size()) {
    uint32_t flips = 0;
    if (lanes.rank() == 0)
      for (uint32_t k = 0; k < L::size() && first + k < count; ++k)
        flips |= static_cast<uint32_t>(data.flip(first + k)) << k;
    const bool flip = (broadcast(lanes, flips, 0) >> lanes.rank() & 1) != 0;
    const uint32_t i = first + lanes.rank();
    if (i >= count) continue;
    const Index corner = on.sequence.corner[i];
    Vec3 normal = sums.empty() ? normal_at(on.table, positions, corner) : sums[on.table.vertex[corner]];
    shorten(normal);
    const int32_t* by = on.correction(i);
    int32_t* const out = on.at(corner);
    const Vec2 value = data.grid.correct(data.grid.project(normal, flip), {by[0], by[1]}, canonicalized);
    out[0] = value.s, out[1] = value.t;
  }
  lanes.sync();
}

#if defined(PSPLIT_HAS_VECTORS)
// Predicts all values, several at once, if their corrections are in range (OctahedralChain) and the grid is no
// finer than kMostExactBits. Then quotients of integers below 2^53 are computed as doubles: one that is not
// whole is farther from the next integer than its rounding moves it.
inline constexpr int kMostExactBits = 24;
inline bool is_exact(const OctahedralGrid& grid) { return grid.max_quantized() >> kMostExactBits == 0; }
template <typename Index>
void predict_from_sums(const PredictedValues<Index, 2>& on, View<const Vec3> sums, PredictionData& data) {
  using Ints = int32_t __attribute__((vector_size(16)));
  using Half = int32_t __attribute__((vector_size(8)));
  using Doubles = double __attribute__((vector_size(16)));
  constexpr uint32_t kAtOnce = 4;
  const auto center = static_cast<int64_t>(data.grid.max_quantized() / 2);
  const uint32_t count = on.sequence.count;
  OctahedralChain<Ints> chain(data.grid, data.transform == Transform::kOctahedronCanonicalized);
  for (uint32_t first = 0; first < count; first += kAtOnce) {
    const uint32_t some = count - first < kAtOnce ? count - first : kAtOnce;
    int32_t* out[kAtOnce];
    Ints x{}, y{}, is_back{}, flip{}, s{}, t{};
    for (uint32_t k = 0; k < some; ++k) {
      const uint32_t i = first + k, vertex = on.table.vertex[on.sequence.corner[i]];
      Vec3 normal = sums[vertex];
      int64_t length = shorten(normal);
      if (PSPLIT_UNLIKELY(length == 0)) normal.x = length = 1;
      const auto whole = static_cast<double>(length);
      const Doubles scaled{static_cast<double>(normal.x * center), static_cast<double>(normal.y * center)};
      const Half place = __builtin_convertvector(scaled / Doubles{whole, whole}, Half);
      x[k] = place[0], y[k] = place[1];
      is_back[k] = static_cast<int32_t>(normal.z >> 63);
      flip[k] = -static_cast<int32_t>(data.flip(i));
      const int32_t* by = on.correction(i);
      s[k] = by[0], t[k] = by[1];
      out[k] = on.of_vertex(vertex);
    }
    chain.start_at(x, y, is_back, flip);
    chain.step(s, t);
    for (uint32_t k = 0; k < some; ++k) out[k][0] = s[k], out[k][1] = t[k];
  }
}
#endif

}  // namespace psplit::core
