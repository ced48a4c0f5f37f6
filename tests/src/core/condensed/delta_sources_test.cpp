// The weights of what predicts deltas.
#include "src/core/condensed/delta_sources.h"

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <random>

#include "src/core/condensed/deltas.h"
#include "tests/support/expect.h"

namespace psplit::core {
namespace {

int sum_of(const DeltaWeights& weights) {
  int sum = 0;
  for (const int16_t weight : weights.of) sum += weight;
  return sum;
}

TEST(DeltaWeights, SumTo64AndAreAboutEqualIfEven) {
  for (uint32_t count = 1; count <= kMostDeltaSources; ++count) {
    const DeltaWeights weights = even_delta_weights(count);
    EXPECT_EQ(sum_of(weights), kDeltaOne);
    for (uint32_t n = 0; n < kMostDeltaSources; ++n) {
      EXPECT_LE(std::abs(weights.of[n] - (n < count ? kDeltaOne / static_cast<int>(count) : 0)), 4);
    }
  }
  EXPECT_EQ(sum_of(even_delta_weights(0)), 0);
}

// Around a vertex lie places in a plane or in space. Affine functions of the places are predicted within the
// weights' steps.
TEST(DeltaWeights, PredictAffineFunctions) {
  std::mt19937 random(1);
  const auto between = [&](int low, int high) {
    return low + static_cast<int>(random() % static_cast<uint32_t>(high - low + 1));
  };
  double largest = 0, sum = 0;
  constexpr int kTries = 2000;
  for (int i = 0; i < kTries; ++i) {
    const auto count = static_cast<uint32_t>(between(5, 8));
    std::array<std::array<int32_t, 3>, kMostDeltaSources> places{};
    DeltaOffset offsets[kMostDeltaSources] = {};
    for (uint32_t n = 0; n < count; ++n)
      for (uint32_t k = 0; k < 3; ++k) offsets[n].of[k] = places[n][k] = between(-100, 100);
    const int slope[3] = {between(-9, 9), between(-9, 9), between(-9, 9)};
    const DeltaWeights weights = affine_delta_weights(offsets, count);
    ASSERT_EQ(sum_of(weights), kDeltaOne);
    double predicted = 0;
    for (uint32_t n = 0; n < count; ++n)
      for (uint32_t k = 0; k < 3; ++k) predicted += weights.of[n] / 64.0 * slope[k] * places[n][k];
    largest = std::max(largest, std::abs(predicted));
    sum += std::abs(predicted);
  }
  // Even weights are off by some 200 here.
  EXPECT_LT(sum / kTries, 80);
  EXPECT_GT(largest, 0);
}

// The test compares code with vectors and without them. Sanitizers watch the arithmetic.
TEST(DeltaWeights, SumTo64AtAnyPlaces) {
  std::mt19937 random(2);
  constexpr int32_t kSpecial[] = {0, 1, -1, 127, -128, 128, INT32_MAX, INT32_MIN, 1 << 20};
  for (int i = 0; i < 20000; ++i) {
    const uint32_t count = 1 + random() % kMostDeltaSources, kind = random() % 4;
    DeltaOffset offsets[kMostDeltaSources] = {};
    for (uint32_t n = 0; n < count; ++n)
      for (int32_t& at : offsets[n].of)
        at = kind == 0   ? static_cast<int32_t>(random())
             : kind == 1 ? kSpecial[random() % std::size(kSpecial)]
             : kind == 2 ? static_cast<int32_t>(random() % 3)
                         : 0;
    const DeltaWeights weights = affine_delta_weights(offsets, count);
    ASSERT_EQ(sum_of(weights), kDeltaOne);
    if (count > 1) {
      DeltaFit fit;
      fit_plainly(offsets, count, fit);
      ASSERT_TRUE(std::ranges::equal(weights.of, delta_weights(fit, delta_plane(fit), count).of));
    }
    for (uint32_t n = count; n < kMostDeltaSources; ++n) ASSERT_EQ(weights.of[n], 0);
  }
}

#if defined(PSPLIT_HAS_SSE2_DELTAS)
// As a sorted set of all candidates has them.
TEST(LatestPlaces, AreTheEightLatestCandidates) {
  std::mt19937 random(4);
  for (int i = 0; i < 20000; ++i) {
    const uint32_t most = random() % 2 == 0 ? 12 : LatestPlaces::kMostPlaces,
                   tries = static_cast<uint32_t>(random() % 20);
    std::map<uint32_t, uint32_t, std::greater<>> candidates;  // by place: whether it is a neighbour
    LatestPlaces latest;
    for (uint32_t n = 0; n < tries; ++n) {
      const auto place = static_cast<uint32_t>(random() % most),
                 is_neighbour = static_cast<uint32_t>(random() % 2);
      const bool condition = random() % 3 != 0;
      latest.add(place, is_neighbour, condition);
      if (condition) candidates[place] |= is_neighbour;
    }
    latest.add(~0u, 1, false);
    latest.add(most - 1, 0, true);  // the last place of the order
    candidates[most - 1] |= 0;
    DeltaSources<uint16_t> found;
    latest.store(found);
    ASSERT_EQ(found.count, std::min<size_t>(candidates.size(), kMostDeltaSources));
    uint32_t n = 0;
    for (auto at = candidates.begin(); n < kMostDeltaSources; ++n) {
      ASSERT_EQ(found.place[n], n < found.count ? at->first : 0);
      ASSERT_EQ(found.neighbours >> n & 1u, n < found.count ? at->second : 0);
      if (n < found.count) ++at;
    }
  }
}
#endif

// The test compares code with vectors and without them.
TEST(DeltaRecord, HasTheNearestNumbersOf16Bits) {
  std::mt19937 random(3);
  for (int i = 0; i < 20000; ++i) {
    DeltaValues remainders = {}, corrections = {};
    for (uint32_t k = 0; k < kDeltaComponents; ++k) {
      remainders.of[k] = static_cast<int32_t>(random()) >> random() % 32;
      corrections.of[k] = i == 0 ? INT32_MIN : static_cast<int32_t>(random()) >> random() % 32;
    }
    const DeltaRecord record = delta_record(DeltaBlock(remainders.of), DeltaBlock(corrections.of));
    for (uint32_t k = 0; k < kDeltaComponents; ++k) {
      ASSERT_EQ(record.remainders[k], std::clamp(remainders.of[k], -0x8000, 0x7fff));
      ASSERT_EQ(record.sizes[k], std::min(magnitude(corrections.of[k]), kMostDeltaSize));
    }
    ASSERT_EQ(record.remainders[3], 0);
  }
}

TEST(DeltaLevels, GrowWithTheMean) {
  EXPECT_EQ(delta_level(0), 0);
  EXPECT_EQ(delta_level(1), 1);
  for (uint32_t mean = 1; mean <= kMostMeanSize; ++mean) {
    EXPECT_GE(delta_level(mean), delta_level(mean - 1));
    EXPECT_LE(delta_level(mean), delta_level(mean - 1) + 1);
  }
  EXPECT_EQ(delta_level(kMostMeanSize), DeltaTables::kLevels - 2);
  EXPECT_EQ(delta_level(kNoMeanSize), DeltaTables::kLevels - 1);
}

}  // namespace
}  // namespace psplit::core
