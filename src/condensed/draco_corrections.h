// The corrections that libdraco's encoder makes of values: the inverse of core/prediction.h for the schemes
// whose values may be stored otherwise.
#pragma once

#include <algorithm>
#include <vector>

#include "src/condensed/draco_fields.h"
#include "src/core/attributes.h"
#include "src/core/parallelogram.h"
#include "src/core/prediction_data.h"
#include "src/core/stitch_codes.h"

namespace psplit {

class DracoCorrections {
 public:
  // An attribute that allows_creation_order, when its values are known. `data` has its scheme and transform.
  DracoCorrections(const core::Group<uint32_t>& group, const core::Attribute<uint32_t>& attribute,
                   const core::PredictionData& data)
      : zeros_(attribute.value_components()), attribute_(attribute), data_(data) {
    on_.table = group.table.table;
    on_.sequence = group.sequence;
    on_.values = attribute.values;
    on_.zeros = zeros_.data();
    on_.component_count = attribute.value_components();
  }

  // Fills the symbols, and the range of the wrap transform. Returns false if the symbols are values: those of
  // an attribute that is not predicted, or whose range no wrap transform has.
  bool write(AttributeFields& out) const {
    out.symbols.resize(size_t{on_.sequence.count} * on_.components());
    const bool is_predicted = data_.scheme != core::Scheme::kNone;
    if (is_predicted && attribute_.coding == core::Coding::kNormal)
      correct_normals(out);
    else if (is_predicted && find_range(out))
      correct_in_range(out);
    else
      return store_values(out), false;
    return true;
  }

 private:
  const int32_t* value(uint32_t i) const { return on_.at(on_.sequence.corner[i]); }

  void store_values(AttributeFields& out) const {
    size_t at = 0;
    for (uint32_t i = 0; i < on_.sequence.count; ++i)
      for (uint32_t k = 0; k < on_.components(); ++k)
        out.symbols[at++] = static_cast<uint32_t>(core::fold(value(i)[k]));
  }

  // Each normal is predicted to be the same as the one before it.
  void correct_normals(AttributeFields& out) const {
    const bool canonicalized = data_.transform == core::Transform::kOctahedronCanonicalized;
    for (uint32_t i = 0; i < on_.sequence.count; ++i) {
      const int32_t *const before = on_.before(i), *const normal = value(i);
      const core::Vec2 by =
          data_.grid.correction({before[0], before[1]}, {normal[0], normal[1]}, canonicalized);
      out.symbols[2 * size_t{i}] = static_cast<uint32_t>(by.s);
      out.symbols[2 * size_t{i} + 1] = static_cast<uint32_t>(by.t);
    }
  }

  void correct_in_range(AttributeFields& out) const {
    size_t at = 0;
    for (uint32_t i = 0; i < on_.sequence.count; ++i) {
      core::Parallelogram by{on_.before(i), on_.zeros, on_.zeros};
      if (data_.scheme == core::Scheme::kParallelogram)
        core::find_parallelogram(on_, i, on_.sequence.corner[i], by);
      for (uint32_t k = 0; k < on_.components(); ++k) {
        const int32_t predicted = by.predicted<core::Components<1>>(k)[0];
        out.symbols[at++] = static_cast<uint32_t>(core::fold(wrapped(value(i)[k], predicted, out)));
      }
    }
  }

  // False if the wrap transform does not allow the range.
  bool find_range(AttributeFields& out) const {
    out.wrap_min = out.wrap_max = 0;
    for (uint32_t i = 0; i < on_.sequence.count; ++i)
      for (uint32_t k = 0; k < on_.components(); ++k) {
        const int32_t number = value(i)[k];
        const bool is_first = i == 0 && k == 0;
        out.wrap_min = is_first ? number : std::min(out.wrap_min, number);
        out.wrap_max = is_first ? number : std::max(out.wrap_max, number);
      }
    return int64_t{out.wrap_max} - out.wrap_min < 0x7fffffff;
  }

  // Of the corrections that give the same value, modulo the number of values in the range, the one nearest to
  // 0.
  static int64_t wrapped(int32_t number, int32_t predicted, const AttributeFields& range) {
    const int64_t modulus = int64_t{range.wrap_max} - range.wrap_min + 1;
    const int64_t highest = (modulus - 1) / 2, lowest = -(modulus / 2);
    const int64_t correction = int64_t{number} - std::clamp(predicted, range.wrap_min, range.wrap_max);
    return correction > highest  ? correction - modulus
           : correction < lowest ? correction + modulus
                                 : correction;
  }

  std::vector<int32_t> zeros_;
  core::PredictedValues<uint32_t, 0> on_;
  const core::Attribute<uint32_t>& attribute_;
  const core::PredictionData& data_;
};

}  // namespace psplit
