// Parallelogram prediction: two triangles that share an edge are predicted to form a parallelogram.
//
// C. Touma, C. Gotsman: Triangle Mesh Compression, 1998. Draco bitstream specification 2.2, "parallelogram
// prediction".
#pragma once

#include "src/core/predicted_values.h"
#include "src/core/value_chain.h"

namespace psplit::core {

// Three values that predict a fourth, each of which comes before it in the sequence.
//
//        far
//       /   \            predicted = a + b - far
//      a-----b
//       \   /
//     predicted
struct Parallelogram {
  const int32_t *a, *b, *far;

  // The block of the predicted value that starts at component k.
  template <typename Block>
  PSPLIT_HD Block predicted(uint32_t k) const {
    return Block(a + k) + Block(b + k) - Block(far + k);
  }
};

// The parallelogram whose far corner is `across`.
template <typename Index, uint32_t kComponents>
PSPLIT_HD inline Parallelogram parallelogram_at(const PredictedValues<Index, kComponents>& on, Index across) {
  return {on.at(next(across)), on.at(previous(across)), on.at(across)};
}

// Finds the parallelogram that predicts value i at one of its corners. False, and `found` is as before, if
// there is no face across from the corner, or if one of its values does not come before value i.
template <typename Index, uint32_t kComponents>
PSPLIT_HD inline bool find_parallelogram(const PredictedValues<Index, kComponents>& on, uint32_t i,
                                         Index corner, Parallelogram& found) {
  const Index across = on.table.opposite[corner];
  if (PSPLIT_UNLIKELY(across == kNone<Index>)) return false;
  const View<Index> rank = on.sequence.rank, vertex = on.table.vertex;
  const uint32_t far = vertex[across], a = vertex[next(across)], b = vertex[previous(across)];
  if (PSPLIT_UNLIKELY(rank[far] >= i || rank[a] >= i || rank[b] >= i)) return false;
  found = {on.of_vertex(a), on.of_vertex(b), on.of_vertex(far)};
  return true;
}

// Computes one value a step. A value without a parallelogram is predicted to be the same as the value before
// it.
template <typename Index, uint32_t kComponents>
class ParallelogramSteps {
 public:
  ParallelogramSteps() = default;
  PSPLIT_HD explicit ParallelogramSteps(const WrappedValues<Index, kComponents>& on)
      : on_(on), last_(on.zeros) {}

  PSPLIT_HD uint32_t steps_left() const { return on_.sequence.count - i_; }
  PSPLIT_HD PSPLIT_INLINE void step() {
    using Block = typename WrappedValues<Index, kComponents>::Block;
    if constexpr (sizeof(Index) == 4 && !PSPLIT_IS_SMALL_CODE) {
      // Tables of 32 bits seldom fit a processor's second cache.
      constexpr uint32_t kFar = 16, kNear = 8;
      const uint32_t last = on_.sequence.count - 1;
      PSPLIT_PREFETCH(&on_.table.opposite[on_.sequence.corner[i_ + kFar < last ? i_ + kFar : last]]);
      const Index soon = on_.table.opposite[on_.sequence.corner[i_ + kNear < last ? i_ + kNear : last]];
      PSPLIT_PREFETCH(&on_.table.vertex[soon == kNone<Index> ? 0 : soon]);
    }
    const Index corner = on_.sequence.corner[i_];
    Parallelogram known{last_, on_.zeros, on_.zeros};
    find_parallelogram(on_, i_, corner, known);
    int32_t* const out = on_.at(corner);
    on_.correct(i_, out, [&](uint32_t k) { return known.predicted<Block>(k); });
    last_ = out;
    ++i_;
  }

 private:
  WrappedValues<Index, kComponents> on_;
  const int32_t* last_ = nullptr;
  uint32_t i_ = 0;
};

// Computes all values, as ParallelogramSteps does, by lanes. The corrections are still symbols. Collective.
template <Lanes L, typename Index, uint32_t kComponents>
PSPLIT_HD void predict_by_parallelogram(L lanes, const PredictedValues<Index, kComponents>& on,
                                        const WrapRange& range) {
  constexpr uint32_t kValues = ValueLane<kComponents, L>::kValues, kSources = 3;  // a, b and far
  const ValueLane<kComponents, L> lane(lanes);
  const Wrap<1> wrap(range);
  const View<const Index> opposite = on.table.opposite, vertex = on.table.vertex, rank = on.sequence.rank;
  const uint32_t count = on.sequence.count;
  for (uint32_t first = 0; first < count; first += kValues) {
    const uint32_t i = first + lane.value;
    const bool is_busy = lane.is_busy() && i < count;
    int32_t sources[kSources] = {}, correction = 0;
    uint32_t from[kSources] = {kValues, kValues, kValues};
    int32_t* out = nullptr;
    if (is_busy) {
      const auto take = [&](uint32_t source, uint32_t v, uint32_t place) {
        if (place >= first)
          from[source] = place - first;
        else
          sources[source] = on.of_vertex(v)[lane.component];
      };
      const Index corner = on.sequence.corner[i], across = opposite[corner];
      out = on.at(corner) + lane.component;
      correction =
          static_cast<int32_t>(signed_of_symbol(static_cast<uint32_t>(on.correction(i)[lane.component])));
      bool is_predicted = across != kNone<Index>;
      if (is_predicted) {
        const uint32_t a = vertex[next(across)], b = vertex[previous(across)], far = vertex[across];
        const uint32_t of_a = rank[a], of_b = rank[b], of_far = rank[far];
        is_predicted = of_a < i && of_b < i && of_far < i;
        if (is_predicted) take(0, a, of_a), take(1, b, of_b), take(2, far, of_far);
      }
      if (!is_predicted && i > 0) take(0, vertex[on.sequence.corner[i - 1]], i - 1);
    }
    const int32_t value =
        chain_values<kComponents>(lanes, count - first < kValues ? count - first : kValues, sources, from,
                                  [&](const int32_t(&at)[kSources]) {
                                    const int32_t predicted = wrapping_sub(wrapping_add(at[0], at[1]), at[2]);
                                    return wrap(Components<1>(predicted), Components<1>(correction))[0];
                                  });
    if (is_busy) *out = value;
    lanes.sync();
  }
}

}  // namespace psplit::core
