// Parallelogram prediction: two triangles that share an edge are predicted to form a parallelogram.
//
// C. Touma, C. Gotsman: Triangle Mesh Compression, 1998. Draco bitstream specification 2.2, "parallelogram
// prediction".
#pragma once

#include "src/core/predicted_values.h"

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

  PSPLIT_HD bool running() const { return i_ < on_.sequence.count; }
  PSPLIT_HD void step() {
    using Block = typename WrappedValues<Index, kComponents>::Block;
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

}  // namespace psplit::core
