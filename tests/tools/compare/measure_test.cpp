#include "tools/gltf_psplit/compare/measure.h"

#include <gtest/gtest.h>

namespace psplit {
namespace {

TEST(Measure, SummarizesSamples) {
  const Timing odd = summarize_samples({5, 1, 3});
  EXPECT_EQ(odd.median_ms, 3);
  EXPECT_EQ(odd.min_ms, 1);
  EXPECT_EQ(odd.max_ms, 5);
  EXPECT_EQ(odd.lower_quartile_ms, 2);
  EXPECT_EQ(odd.upper_quartile_ms, 4);
  const Timing even = summarize_samples({4, 1, 2, 9});
  EXPECT_EQ(even.median_ms, 3);
  EXPECT_EQ(even.lower_quartile_ms, 1.75);
  EXPECT_EQ(even.upper_quartile_ms, 5.25);
  const Timing one = summarize_samples({7});
  EXPECT_EQ(one.lower_quartile_ms, 7);
  EXPECT_EQ(one.upper_quartile_ms, 7);
}

TEST(Measure, RunsContendersInTurnWithOneRoundToWarmUp) {
  std::string order;
  const std::vector<Contender> contenders{{"a", [&] { return order += 'a', Status(); }},
                                          {"b", [&] { return order += 'b', Status(); }}};
  size_t last = 0;
  const auto timings = measure_interleaved(contenders, 2, [&](size_t done, size_t total) {
    EXPECT_EQ(total, 6u);
    last = done;
  });
  ASSERT_TRUE(timings.ok());
  EXPECT_EQ(timings->size(), 2u);
  EXPECT_EQ(order, "ababab");
  EXPECT_EQ(last, 6u);
}

TEST(Measure, StopsAtTheFirstFailureAndNamesIt) {
  int runs = 0;
  const std::vector<Contender> contenders{{"good", [&] { return ++runs, Status(); }},
                                          {"bad", [&] { return runtime_failure("broke"); }}};
  const auto timings = measure_interleaved(contenders, 3);
  ASSERT_FALSE(timings.ok());
  EXPECT_EQ(timings.status().message(), "bad: broke");
  EXPECT_EQ(runs, 1);
}

}  // namespace
}  // namespace psplit
