// Computes the corrections that libdraco's encoder stores for values: the inverse of core/prediction.h. This
// file has the schemes whose values may also be stored in other forms. encoder/stream has the other schemes.
#pragma once

#include <algorithm>
#include <vector>

#include "encoder/fields/draco_fields.h"
#include "src/core/attributes.h"
#include "src/core/parallelogram.h"
#include "src/core/prediction_data.h"
#include "src/core/stitch_codes.h"

namespace psplit {

// The values of an attribute, when they are known, in the order of their group. `zeros` has a value of zeros.
template <uint32_t kComponents>
core::PredictedValues<uint32_t, kComponents> known_values(const core::Group<uint32_t>& group,
                                                          const core::Attribute<uint32_t>& attribute,
                                                          const int32_t* zeros) {
  core::PredictedValues<uint32_t, kComponents> on;
  on.table = group.table.table;
  on.sequence = group.sequence;
  on.values = attribute.values;
  on.zeros = zeros;
  on.component_count = attribute.value_components();
  return on;
}

// The inverse of core::Wrap.
template <uint32_t kComponents>
class WrapCorrections {
 public:
  using Values = core::PredictedValues<uint32_t, kComponents>;

  // Finds the range of the values. Returns false if the wrap transform does not allow it. Each vertex has a
  // place in the order of the group, so all values are read in the order of memory.
  bool find_range(const Values& on) {
    const uint32_t count = on.sequence.count;
    low_ = high_ = count > 0 ? on.of_vertex(0)[0] : 0;
    for (uint32_t vertex = 0; vertex < count; ++vertex) {
      const int32_t* const value = on.of_vertex(vertex);
      for (uint32_t k = 0; k < on.components(); ++k) {
        low_ = std::min(low_, value[k]);
        high_ = std::max(high_, value[k]);
      }
    }
    const int64_t difference = int64_t{high_} - low_;
    modulus_ = difference + 1;
    highest_ = difference / 2;
    lowest_ = -(modulus_ / 2);
    return difference < 0x7fffffff;
  }
  void write_range(AttributeFields& out) const {
    out.wrap_min = low_;
    out.wrap_max = high_;
  }

  // The correction as a symbol. Several corrections give one number, modulo the count of numbers in the range:
  // this is the one nearest to 0.
  uint32_t symbol(int32_t number, int32_t predicted) const {
    int64_t correction = int64_t{number} - std::clamp(predicted, low_, high_);
    correction -= correction > highest_ ? modulus_ : 0;
    correction += correction < lowest_ ? modulus_ : 0;
    return static_cast<uint32_t>(core::fold(correction));
  }

 private:
  int32_t low_ = 0, high_ = 0;
  int64_t modulus_ = 0, highest_ = 0, lowest_ = 0;
};

class DracoCorrections {
 public:
  // An attribute that allows_creation_order, when its values are known. `data` has its scheme and transform.
  DracoCorrections(const core::Group<uint32_t>& group, const core::Attribute<uint32_t>& attribute,
                   const core::PredictionData& data)
      : group_(group), attribute_(attribute), data_(data) {}

  // Fills the symbols, and the range of the wrap transform. Returns false if the symbols are the values
  // themselves: if the attribute is not predicted, or if no wrap transform has its range.
  bool write(AttributeFields& out) const {
    switch (attribute_.value_components()) {
      case 2: return write<2>(out);
      case 3: return write<3>(out);
      default: return write<0>(out);
    }
  }

 private:
  template <uint32_t kComponents>
  bool write(AttributeFields& out) const {
    const std::vector<int32_t> zeros(attribute_.value_components());
    const auto on = known_values<kComponents>(group_, attribute_, zeros.data());
    out.symbols.resize(size_t{on.sequence.count} * on.components());
    out.wrap_min = out.wrap_max = 0;
    const bool is_predicted = data_.scheme != core::Scheme::kNone;
    if constexpr (kComponents == 2)
      if (is_predicted && attribute_.coding == core::Coding::kNormal) return correct_normals(on, out), true;
    WrapCorrections<kComponents> wrap;
    if (is_predicted && wrap.find_range(on)) return correct_in_range(on, wrap, out), true;
    return store_values(on, out), false;
  }

  template <uint32_t kComponents>
  static void store_values(const core::PredictedValues<uint32_t, kComponents>& on, AttributeFields& out) {
    size_t at = 0;
    for (uint32_t i = 0; i < on.sequence.count; ++i)
      for (uint32_t k = 0; k < on.components(); ++k)
        out.symbols[at++] = static_cast<uint32_t>(core::fold(on.at(on.sequence.corner[i])[k]));
  }

  // Each normal is predicted to be the same as the one before it.
  void correct_normals(const core::PredictedValues<uint32_t, 2>& on, AttributeFields& out) const {
    const bool canonicalized = data_.transform == core::Transform::kOctahedronCanonicalized;
    const int32_t* before = on.zeros;
    for (uint32_t i = 0; i < on.sequence.count; ++i) {
      const int32_t* const normal = on.at(on.sequence.corner[i]);
      const core::Vec2 by =
          data_.grid.correction({before[0], before[1]}, {normal[0], normal[1]}, canonicalized);
      out.symbols[2 * size_t{i}] = static_cast<uint32_t>(by.s);
      out.symbols[2 * size_t{i} + 1] = static_cast<uint32_t>(by.t);
      before = normal;
    }
  }

  template <uint32_t kComponents>
  void correct_in_range(const core::PredictedValues<uint32_t, kComponents>& on,
                        const WrapCorrections<kComponents>& wrap, AttributeFields& out) const {
    const bool by_parallelogram = data_.scheme == core::Scheme::kParallelogram;
    wrap.write_range(out);
    uint32_t* to = out.symbols.data();
    const int32_t* before = on.zeros;
    for (uint32_t i = 0; i < on.sequence.count; ++i) {
      const uint32_t corner = on.sequence.corner[i];
      core::Parallelogram by{before, on.zeros, on.zeros};
      if (by_parallelogram) core::find_parallelogram(on, i, corner, by);
      const int32_t* const value = on.at(corner);
      for (uint32_t k = 0; k < on.components(); ++k)
        *to++ = wrap.symbol(value[k], by.predicted<core::Components<1>>(k)[0]);
      before = value;
    }
  }

  const core::Group<uint32_t>& group_;
  const core::Attribute<uint32_t>& attribute_;
  const core::PredictionData& data_;
};

}  // namespace psplit
