// Prediction: a stream stores each value as the correction of a value that is predicted from those before it.
// Draco bitstream specification 2.2, "prediction schemes" and "prediction transforms".
//
//   prediction_data.h      the schemes and transforms, and what they store besides corrections
//   wrap.h, octahedral.h   the transforms: a predicted value and a correction -> a value
//   octahedral_chain.h     the same, for places that are predicted from the one before
//   predicted_values.h     the values, their order and their corrections
//   parallelogram.h        from the triangle across an edge
//   multi_parallelogram.h  from several such triangles
//   tex_coords.h           texture coordinates, from positions
//   normals.h              normals, from the normal before or from positions
#pragma once

#include "src/core/multi_parallelogram.h"
#include "src/core/normals.h"
#include "src/core/tex_coords.h"

namespace psplit::core {

// Predicts each value to be the value before it. Each step waits for the one before, so it computes no more
// than it needs: if all corrections are as an encoder writes them, all predicted values are in the range
// already.
template <typename Index, uint32_t kComponents>
PSPLIT_HD void predict_by_difference(const PredictedValues<Index, kComponents>& on, const WrapRange& range) {
  if constexpr (kComponents != 0 && !PSPLIT_MOVES_ROWS && !PSPLIT_IS_SMALL_CODE) {
    if (are_corrections_of(range, on.corrections.first(size_t{on.sequence.count} * kComponents))) {
      using Block = Components<kComponents>;
      const Wrap<kComponents> wrap(range);
      Block last = wrap.clamped(Block(on.zeros));
      for (uint32_t i = 0; i < on.sequence.count; ++i) {
        last = wrap.sum(last, Block(on.correction(i)));
        last.store(on.at(on.sequence.corner[i]));
      }
      return;
    }
  }
  const Wrap<1> wrap(range);
  for (uint32_t i = 0; i < on.sequence.count; ++i) {
    const int32_t *const before = on.before(i), *const by = on.correction(i);
    int32_t* const out = on.at(on.sequence.corner[i]);
    for (uint32_t k = 0; k < on.components(); ++k)
      wrap(Components<1>(before + k), Components<1>(by + k)).store(out + k);
  }
}

// Computes the values of an attribute from its corrections, except those that IntegerDecoder has steps for:
// parallelograms of two and three components, on hosts also of four, and normals by difference. kComponents
// is 0 if their number is known only at run time. `parallelograms` come from an earlier attribute, or are
// empty; if others are needed, they are found in the arena's memory.
template <typename Index, uint32_t kComponents>
PSPLIT_HD Fault predict(const PredictedValues<Index, kComponents>& on, const PredictionData& data,
                        ParallelogramFinder<Index>& parallelograms, Arena& arena) {
  const WrappedValues<Index, kComponents> wrapped(on, data.wrap);
  switch (data.scheme) {
    case Scheme::kNone:
      for (uint32_t i = 0; i < on.sequence.count; ++i)
        for (uint32_t k = 0; k < on.components(); ++k) on.at(on.sequence.corner[i])[k] = on.correction(i)[k];
      return Fault::kNone;
    case Scheme::kDifference: return predict_by_difference(on, data.wrap), Fault::kNone;
    case Scheme::kParallelogram:
      if constexpr (kComponents != 2 && kComponents != 3)
        for (ParallelogramSteps<Index, kComponents> steps(wrapped); steps.steps_left() > 0;) steps.step();
      return Fault::kNone;
    case Scheme::kMultiParallelogram: predict_by_multi_parallelogram(wrapped); return Fault::kNone;
    case Scheme::kConstrainedMultiParallelogram: {
      const Fault fault = parallelograms.find(on.table, on.sequence, arena);
      if (fault != Fault::kNone) return fault;
      return predict_by_constrained_multi_parallelogram(wrapped, parallelograms, data.creases);
    }
    case Scheme::kTexCoords:
    case Scheme::kGeometricNormal: break;
  }
  return Fault::kPrediction;
}

// Computes the values for the schemes that predict from positions: kTexCoords and kGeometricNormal. Normals are
// faster if the arena has normal_sum_bytes.
template <typename Index>
PSPLIT_HD Fault predict_from_positions(const PredictedValues<Index, 2>& on, const Positions<Index>& positions,
                                       PredictionData& data, Arena& arena) {
  if (data.scheme == Scheme::kGeometricNormal) {
    const View<Vec3> sums = sum_normals(on.table, positions, on.sequence.count, arena);
#if defined(PSPLIT_HAS_VECTORS)
    if (!PSPLIT_IS_SMALL_CODE && !sums.empty() && is_exact(data.grid) && are_in_range(on, data.grid))
      return predict_from_sums(on, View<const Vec3>(sums), data), Fault::kNone;
#endif
    return predict_from_geometry(SerialLanes(), on, positions, sums, data), Fault::kNone;
  }
  const WrappedValues<Index, 2> wrapped(on, data.wrap);
  return TexCoordsPredictor<Index>(wrapped, positions, data.orientations).predict();
}

}  // namespace psplit::core
