#include "tools/gltf_psplit/compare/measure.h"

#include "src/stopwatch.h"
#include "tests/support/expect.h"

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
  const auto measured = measure_interleaved(contenders, {.count = 2}, [&](size_t done, size_t total) {
    EXPECT_EQ(total, 6u);
    last = done;
  });
  ASSERT_TRUE(measured.ok());
  EXPECT_EQ(measured->timings.size(), 2u);
  EXPECT_EQ(measured->rounds, 2);
  EXPECT_EQ(order, "ababab");
  EXPECT_EQ(last, 6u);
}

TEST(Measure, StopsAtTheFirstFailureAndNamesIt) {
  int runs = 0;
  const std::vector<Contender> contenders{{"good", [&] { return ++runs, Status(); }},
                                          {"bad", [&] { return runtime_failure("broke"); }}};
  const auto measured = measure_interleaved(contenders, {.count = 3});
  ASSERT_FALSE(measured.ok());
  EXPECT_EQ(measured.status().message(), "bad: broke");
  EXPECT_EQ(runs, 1);
}

TEST(Measure, KnowsHowCertainAMedianIs) {
  const Timing timing{10, 8, 20, 9.5, 10.5};
  EXPECT_NEAR(median_uncertainty(timing, 25), 1.57 * 0.1 / 5, 1e-12);
  EXPECT_FALSE(is_certain(timing, 25));
  EXPECT_TRUE(is_certain(timing, 36));
  // Too few rounds show no spread.
  EXPECT_FALSE(is_certain({10, 10, 10, 10, 10}, kFewestRounds - 1));
  EXPECT_TRUE(is_certain({10, 10, 10, 10, 10}, kFewestRounds));
}

// A contender whose times are very uneven, so that no number of rounds is enough.
Contender uneven(int& runs, bool decides) {
  const auto wait = [&runs] {
    const Stopwatch watch;
    while (watch.ms() < (runs % 2 == 0 ? 0.1 : 2)) {
    }
    ++runs;
    return Status();
  };
  return {"uneven", wait, decides};
}

TEST(Measure, MeasuresUntilTheTimeIsOverWhereMediansStayUncertain) {
  int runs = 0;
  const std::vector<Contender> contenders{uneven(runs, true)};
  size_t last = 0;
  const auto measured = measure_interleaved(contenders, {.seconds = 0.5}, [&](size_t done, size_t total) {
    EXPECT_EQ(done, last + 1);
    EXPECT_LE(done, total);
    last = done;
  });
  ASSERT_TRUE(measured.ok());
  EXPECT_GT(measured->rounds, kFewestRounds);
  EXPECT_EQ(runs, measured->rounds + 1);
  EXPECT_FALSE(is_certain(measured->timings[0], measured->rounds));
}

TEST(Measure, TakesTheFewestRoundsIfNothingElseDecides) {
  int runs = 0;
  const std::vector<Contender> contenders{uneven(runs, false)};
  EXPECT_EQ(must(measure_interleaved(contenders, {})).rounds, kFewestRounds);
  // A time that is over is no reason for fewer.
  const std::vector<Contender> deciding{uneven(runs, true)};
  EXPECT_EQ(must(measure_interleaved(deciding, {.seconds = 0})).rounds, kFewestRounds);
}

}  // namespace
}  // namespace psplit
