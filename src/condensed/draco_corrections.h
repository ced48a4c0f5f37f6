// The corrections that libdraco's encoder makes of values: the inverse of core/prediction.h for the schemes
// whose values may be stored otherwise.
#pragma once

#include <algorithm>
#include <vector>

#include "src/condensed/draco_fields.h"
#include "src/core/parallelogram.h"
#include "src/core/prediction_data.h"
#include "src/core/stitch_codes.h"

namespace psplit {

class DracoCorrections {
 public:
  // `values` are by vertex of the table, value_stride apart. `scheme` is kNone, kDifference or kParallelogram.
  DracoCorrections(const core::CornerTable<uint32_t>& table, const core::Sequence<uint32_t>& sequence,
                   core::View<int32_t> values, uint32_t components, core::Scheme scheme)
      : zeros_(components), scheme_(scheme) {
    on_.table = table;
    on_.sequence = sequence;
    on_.values = values;
    on_.zeros = zeros_.data();
    on_.component_count = components;
  }

  // Fills the symbols, and the range of the wrap transform. False if the range is one that no stream has.
  bool write(AttributeFields& out) const {
    const bool wraps = scheme_ != core::Scheme::kNone;
    if (wraps && !find_range(out)) return false;
    out.symbols.resize(size_t{on_.sequence.count} * on_.components());
    size_t at = 0;
    for (uint32_t i = 0; i < on_.sequence.count; ++i) {
      core::Parallelogram by{on_.before(i), on_.zeros, on_.zeros};
      const uint32_t corner = on_.sequence.corner[i];
      if (scheme_ == core::Scheme::kParallelogram) core::find_parallelogram(on_, i, corner, by);
      const int32_t* const value = on_.at(corner);
      for (uint32_t k = 0; k < on_.components(); ++k) {
        const int32_t predicted = wraps ? by.predicted<core::Components<1>>(k)[0] : 0;
        const int64_t correction = wraps ? wrapped(value[k], predicted, out) : value[k];
        out.symbols[at++] = static_cast<uint32_t>(core::fold(correction));
      }
    }
    return true;
  }

 private:
  bool find_range(AttributeFields& out) const {
    out.wrap_min = out.wrap_max = 0;
    for (uint32_t i = 0; i < on_.sequence.count; ++i)
      for (uint32_t k = 0; k < on_.components(); ++k) {
        const int32_t number = on_.at(on_.sequence.corner[i])[k];
        const bool is_first = i == 0 && k == 0;
        out.wrap_min = is_first ? number : std::min(out.wrap_min, number);
        out.wrap_max = is_first ? number : std::max(out.wrap_max, number);
      }
    return int64_t{out.wrap_max} - out.wrap_min < 0x7fffffff;
  }

  // Of the corrections that give the same value, modulo the number of values in the range, the one nearest to
  // 0.
  static int64_t wrapped(int32_t value, int32_t predicted, const AttributeFields& range) {
    const int64_t modulus = int64_t{range.wrap_max} - range.wrap_min + 1;
    const int64_t highest = (modulus - 1) / 2, lowest = -(modulus / 2);
    const int64_t correction = int64_t{value} - std::clamp(predicted, range.wrap_min, range.wrap_max);
    return correction > highest  ? correction - modulus
           : correction < lowest ? correction + modulus
                                 : correction;
  }

  std::vector<int32_t> zeros_;
  core::PredictedValues<uint32_t, 0> on_;
  core::Scheme scheme_;
};

}  // namespace psplit
