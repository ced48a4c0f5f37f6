// The wrap transform brings every value of its range back, for any number of components.
#include "src/core/wrap.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace psplit::core {
namespace {

constexpr int32_t kLow = -3, kHigh = 6;
constexpr WrapRange kRange{kLow, kHigh, kHigh - kLow + 1};

// One value through Wrap<kCount>; all components must agree.
template <uint32_t kCount>
int32_t wrapped(int32_t predicted, int32_t correction) {
  int32_t out[4];
  const Wrap<kCount> wrap(kRange);
  wrap(Components<kCount>(predicted), Components<kCount>(correction)).store(out);
  for (uint32_t k = 1; k < kCount; ++k) EXPECT_EQ(out[k], out[0]);
  return out[0];
}

template <uint32_t kCount>
void expect_values_back() {
  for (int32_t predicted = kLow - 5; predicted <= kHigh + 5; ++predicted)
    for (int32_t value = kLow; value <= kHigh; ++value) {
      const int32_t correction = value - std::clamp(predicted, kLow, kHigh);
      EXPECT_EQ(wrapped<kCount>(predicted, correction), value);
      // The other way around.
      if (correction == 0) continue;
      const int32_t around = correction > 0 ? correction - kRange.modulus : correction + kRange.modulus;
      EXPECT_EQ(wrapped<kCount>(predicted, around), value);
    }
}

TEST(Wrap, CorrectionsAreModuloTheNumberOfValues) {
  expect_values_back<1>();
  expect_values_back<2>();
  expect_values_back<3>();
  expect_values_back<4>();
}

TEST(Wrap, ClampsThePredictedValueFirst) {
  EXPECT_EQ(wrapped<2>(100, 0), kHigh);
  EXPECT_EQ(wrapped<3>(100, 0), kHigh);
  EXPECT_EQ(wrapped<2>(100, 1), kLow);
  EXPECT_EQ(wrapped<3>(-100, -1), kHigh);
}

TEST(Wrap, TheRangeHasAtMost31BitsOfValues) {
  const auto read = [](std::initializer_list<uint8_t> bytes) {
    ByteReader reader(bytes.begin(), bytes.size());
    WrapRange range;
    const Fault fault = range.read(reader);
    return std::pair(fault, range.modulus);
  };
  EXPECT_EQ(read({254, 255, 255, 255, 1, 0, 0, 0}), std::pair(Fault::kNone, 4));  // -2 to 1
  EXPECT_EQ(read({1, 0, 0, 0, 0, 0, 0, 0}).first, Fault::kPrediction);            // 1 to 0
  EXPECT_EQ(read({0, 0, 0, 128, 0, 0, 0, 0}).first, Fault::kPrediction);          // -2^31 to 0
  EXPECT_EQ(read({0, 0, 0, 0, 0, 0, 0}).first, Fault::kTruncated);
}

// The mean of three components is computed without divisions.
TEST(Components, MeansRoundTowardZero) {
  for (int32_t sum : {-2'000'000'000, -7, -6, -1, 0, 1, 5, 6, 7, 2'000'000'001})
    for (int32_t count = 1; count <= 4; ++count) {
      int32_t out[4];
      (Components<3>(sum) / count).store(out);
      EXPECT_EQ(out[0], sum / count);
      (Components<2>(sum) / count).store(out);
      EXPECT_EQ(out[1], sum / count);
#if defined(PSPLIT_HAS_VECTORS)
      Components<3>(sum).mean_of(static_cast<uint32_t>(count)).store(out);
      EXPECT_EQ(out[2], sum / count);
#endif
    }
}

}  // namespace
}  // namespace psplit::core
