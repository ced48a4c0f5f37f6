// The wrap transform. All values are in a known range, so corrections are stored modulo the number of values in
// that range. Draco bitstream specification 2.2, "prediction transforms".
#pragma once

#include "src/core/byte_reader.h"
#include "src/core/components.h"
#include "src/core/fault.h"

namespace psplit::core {

// Values are in [low, high], which has `modulus` values.
struct WrapRange {
  int32_t low = 0, high = 0, modulus = 0;

  PSPLIT_HD Fault read(ByteReader& reader) {
    const auto from = static_cast<int32_t>(reader.u32()), to = static_cast<int32_t>(reader.u32());
    return reader.truncated() ? Fault::kTruncated : set(from, to);
  }
  PSPLIT_HD Fault set(int64_t from, int64_t to) {
    const int64_t difference = to - from;
    low = static_cast<int32_t>(from);
    high = static_cast<int32_t>(to);
    if (low != from || high != to) return Fault::kPrediction;
    if (difference < 0 || difference >= 0x7fffffff) return Fault::kPrediction;
    modulus = static_cast<int32_t>(difference + 1);
    return Fault::kNone;
  }
};

// Whether the sum of any value in the range and a correction is at most one modulus outside of it, and fits 32
// bits, for all corrections.
PSPLIT_HD inline bool are_corrections_of(const WrapRange& range, View<const int32_t> corrections) {
  constexpr int32_t kMost = 1 << 29;
  if (range.low < -kMost || range.high > kMost) return false;
  const int32_t modulus = range.modulus;
  uint32_t outside = 0;
  for (size_t i = 0; i < corrections.size(); ++i)
    outside |=
        static_cast<uint32_t>(corrections[i] >= modulus) | static_cast<uint32_t>(corrections[i] <= -modulus);
  return outside == 0;
}

// Undoes the transform, kCount components at once: clamps the predicted value to the range, adds the correction
// and wraps the sum back into the range.
template <uint32_t kCount>
class Wrap {
 public:
  Wrap() = default;
  PSPLIT_HD explicit Wrap(const WrapRange& range) : range_(range) {}

  PSPLIT_HD Components<kCount> operator()(Components<kCount> predicted, Components<kCount> correction) const {
    return sum(clamped(predicted), correction);
  }
  // First the prediction is clamped to the range, then the sum with the correction wraps around.
  PSPLIT_HD Components<kCount> clamped(Components<kCount> predicted) const {
    const auto [low, high, modulus] = range_;
    for (uint32_t k = 0; k < kCount; ++k)
      predicted[k] = predicted[k] > high ? high : predicted[k] < low ? low : predicted[k];
    return predicted;
  }
  PSPLIT_HD Components<kCount> sum(Components<kCount> predicted, Components<kCount> correction) const {
    const auto [low, high, modulus] = range_;
    Components<kCount> value = predicted + correction;
    for (uint32_t k = 0; k < kCount; ++k)
      value[k] = value[k] > high  ? wrapping_sub(value[k], modulus)
                 : value[k] < low ? wrapping_add(value[k], modulus)
                                  : value[k];
    return value;
  }

 private:
  WrapRange range_;
};

#if defined(PSPLIT_HAS_VECTORS)
template <uint32_t kCount>
requires(kCount == 3 || kCount == 4) class Wrap<kCount> {
 public:
  Wrap() = default;
  explicit Wrap(const WrapRange& range) : low_(range.low), high_(range.high), modulus_(range.modulus) {}

  Components<kCount> operator()(Components<kCount> predicted, Components<kCount> correction) const {
    return sum(clamped(predicted), correction);
  }
  Components<kCount> clamped(Components<kCount> predicted) const {
    predicted = choose(above(predicted, high_), high_, predicted);
    return choose(above(low_, predicted), low_, predicted);
  }
  Components<kCount> sum(Components<kCount> predicted, Components<kCount> correction) const {
    const Components<kCount> value = predicted + correction;
    return value - (modulus_ & above(value, high_)) + (modulus_ & above(low_, value));
  }

 private:
  Components<kCount> low_, high_, modulus_;
};
#endif

}  // namespace psplit::core
