#include "tools/gltf_psplit/compare/comparison_summary.h"

#include "tests/support/expect.h"

namespace psplit {
namespace {

constexpr double kStockMs = 60;

Timing steady(double ms) { return {ms, ms * 0.98, ms * 1.05, ms * 0.99, ms * 1.01}; }

struct Measured {
  uint64_t patches;
  double overhead;
  double one_thread_ms, two_threads_ms;
};

Comparison comparison_of(const std::vector<Measured>& list) {
  Comparison comparison;
  comparison.rounds = 15;
  comparison.stock = {5, 1'000'000, 500, steady(kStockMs)};
  comparison.stock_speeds = {comparison.stock};
  // Slower than all, so that only the tests of meshoptimizer's sentence have it.
  comparison.meshopt = comparison.meshopt_plain = {1'500'000, steady(1000)};
  for (const Measured& measured : list) {
    SplitRow& row = comparison.splits.emplace_back();
    row.rule.patches = measured.patches;
    row.summary.patches = measured.patches;
    row.summary.total_bytes = static_cast<uint64_t>(1e6 * (1 + measured.overhead));
    row.overhead = measured.overhead;
    for (const auto& [threads, ms] :
         {std::pair(1, measured.one_thread_ms), std::pair(2, measured.two_threads_ms)})
      row.decode.push_back({"cpu", threads, steady(ms), kStockMs / ms});
    row.decode.push_back(
        {"draco", 1, steady(1), kStockMs});  // ignored however fast, because it is not psplit's own
  }
  return comparison;
}

TEST(ComparisonSummary, SaysInOneSentenceWhatIsGainedForWhat) {
  const ComparisonSummary summary = summarize_comparison(comparison_of({{45, 0.0197, 27, 16}}), "dragon.ply");
  EXPECT_TRUE(summary.has_recommendation);
  EXPECT_EQ(summary.headline,
            "In 45 patches, dragon.ply decodes 3.8 times as fast as stock Draco on 2 threads, for 2.0 % more "
            "bytes; on one thread it is 2.2 times as fast.");
  const auto headline = [](const Measured& measured) {
    return summarize_comparison(comparison_of({measured}), "a").headline;
  };
  EXPECT_EQ(headline({1, 0.0002, 30, 31}),
            "In 1 patch, a decodes 2.0 times as fast as stock Draco on one thread, at the same size.");
  EXPECT_EQ(headline({8, -0.0123, 120, 59}),
            "In 8 patches, a decodes as fast as stock Draco on 2 threads, for 1.2 % fewer bytes; on one thread "
            "it is only 0.5 times as fast.");
}

TEST(ComparisonSummary, HedgesWhatWasMeasuredWithNoise) {
  Comparison comparison = comparison_of({{45, 0.02, 27, 16}, {90, 0.07, 27, 12}});
  const auto summary = [&](int rounds) {
    comparison.rounds = rounds;
    return summarize_comparison(comparison, "a");
  };
  const std::string certain = summary(15).headline;
  EXPECT_FALSE(contains(certain, "about"));
  // Few rounds do not show a spread.
  EXPECT_EQ(
      summary(2).headline,
      "In 45 patches, a decodes about 3.8 times as fast as stock Draco on 2 threads, for 2.0 % more bytes; "
      "on one thread it is about 2.2 times as fast.");
  comparison.splits[0].decode[1].timing = {16, 12, 40, 15, 20};
  EXPECT_EQ(
      summary(15).headline,
      "In 45 patches, a decodes about 3.8 times (3.3 to 4.0) as fast as stock Draco on 2 threads, for 2.0 % "
      "more bytes; on one thread it is 2.2 times as fast.");
  // A noisy time of stock Draco blurs every ratio.
  comparison.stock.decode = {60, 30, 90, 48, 72};
  EXPECT_TRUE(contains(summary(15).headline, "; on one thread it is about 2.2 times (1.8 to 2.6) as fast."));
  EXPECT_TRUE(contains(summary(15).recommendation, "about 5.0 times (4.2 to 5.9) as fast"));
}

TEST(ComparisonSummary, TellsOfAFasterMeshoptimizer) {
  Comparison comparison = comparison_of({{45, 0.02, 27, 16}});
  const auto headline = [&](double ms, uint64_t bytes) {
    comparison.meshopt = {bytes, steady(ms)};
    return summarize_comparison(comparison, "a", {}, {"meshoptimizer 9.8", false}).headline;
  };
  const std::string alone = headline(100, 1'300'000);
  EXPECT_FALSE(contains(alone, "meshoptimizer"));
  EXPECT_EQ(headline(16, 900'000), alone);
  EXPECT_EQ(headline(15.9, 900'000), alone);  // 1.0 times
  EXPECT_EQ(headline(10, 1'300'500), alone +
                                         " meshoptimizer 9.8 with zstd decodes 1.6 times as fast as these "
                                         "patches, on one thread, for 27.5 % more bytes.");
  EXPECT_EQ(headline(2, 969'000), alone +
                                      " meshoptimizer 9.8 with zstd decodes 8.0 times as fast as these "
                                      "patches, on one thread, for 5.0 % fewer bytes.");
  headline(10, 1'300'500);
  // What Debian 12 has makes larger files than current releases.
  EXPECT_TRUE(summarize_comparison(comparison, "a", {}, {"meshoptimizer 0.18", true})
                  .headline.ends_with("for 27.5 % more bytes; its current releases make smaller files."));
  comparison.meshopt.decode = {10, 5, 30, 8, 12};
  EXPECT_TRUE(summarize_comparison(comparison, "a")
                  .headline.ends_with("decodes about 1.6 times (1.4 to 1.9) as fast as these patches, on one "
                                      "thread, for 27.5 % more bytes."));
}

TEST(ComparisonSummary, RecommendsWhatIsThereSoonest) {
  // 1,000,000 bytes take 160 ms.
  const ComparisonSummary summary = summarize_comparison(
      comparison_of({{1, 0, 30, 30}, {45, 0.02, 27, 16}, {182, 0.07, 24, 14}, {726, 0.2, 26, 15}}), "a");
  EXPECT_EQ(summary.recommended_patches, 45u);
  EXPECT_EQ(
      summary.recommendation,
      "Take 45 patches (--patches 45) on 2 threads and on one thread. Over a line of 50 Mbit/s the meshes "
      "are there and decoded after 179 ms on 2 threads, with stock Draco after 220 ms. If only "
      "decoding counts, as from a disk, take 182 patches: 4.3 times as fast as stock Draco on 2 threads, "
      "for 7.0 % more bytes.");
  EXPECT_TRUE(contains(summary.rule, "50 Mbit/s (--line)"));
}

TEST(ComparisonSummary, RecommendsForEachNumberOfThreads) {
  // Many patches cost one thread more than they cost two.
  Comparison comparison = comparison_of({{1, 0, 20, 20}, {45, 0.02, 27, 10}});
  const std::string text = summarize_comparison(comparison, "a").recommendation;
  EXPECT_TRUE(
      text.starts_with("Take 45 patches (--patches 45) on 2 threads, and 1 patch (--patches 1) on one "
                       "thread. Over a line of 50 Mbit/s the meshes are there and decoded after 173 ms "
                       "on 2 threads,"))
      << text;
  // One file serves all where noise may explain the difference.
  Comparison noisy = comparison;
  noisy.splits[1].decode[0].timing = {27, 15, 40, 16, 38};
  EXPECT_TRUE(
      summarize_comparison(noisy, "a")
          .recommendation.starts_with("Take 45 patches (--patches 45) on 2 threads and on one thread."));
  // A single patch gains nothing from more threads, so its time with them is chance.
  comparison.splits[0].decode[1].timing = steady(1);
  EXPECT_EQ(summarize_comparison(comparison, "a").recommendation, text);
  comparison.splits[1].decode.push_back({"cuda", 1, steady(2), 30});
  comparison.splits[0].decode.push_back({"cuda", 1, steady(3), 20});
  EXPECT_TRUE(
      summarize_comparison(comparison, "a")
          .recommendation.starts_with("Take 1 patch (--patches 1) on the GPU, and 45 patches (--patches "
                                      "45) on 2 threads, and 1 patch (--patches 1) on one thread."));
}

TEST(ComparisonSummary, TellsOfAMeshoptimizerThatIsThereSooner) {
  Comparison comparison = comparison_of({{1, 0, 30, 30}, {45, 0.02, 27, 16}});
  comparison.meshopt = {1'050'000, steady(5)};
  EXPECT_TRUE(contains(summarize_comparison(comparison, "a").recommendation,
                       "with stock Draco after 220 ms, and with meshoptimizer and zstd after 173 ms."));
  comparison.meshopt = {1'150'000, steady(5)};
  EXPECT_TRUE(contains(summarize_comparison(comparison, "a").recommendation, "with stock Draco after 220 ms."));
}

TEST(ComparisonSummary, NamesTheOptionThatMakesThePatches) {
  Comparison comparison = comparison_of({{13, 0.01, 24, 12}, {4, 0.005, 40, 26}});
  const auto recommendation = [&](const PatchRule& rule) {
    comparison.splits[0].rule = rule;
    const std::string text = summarize_comparison(comparison, "a").recommendation;
    return text.substr(0, text.find(" on 2"));
  };
  EXPECT_EQ(recommendation({.patches = 9}), "Take 13 patches (--patches 9)");
  EXPECT_EQ(recommendation({.patch_faces = 4800}), "Take 13 patches (--patch-faces 4800)");
  EXPECT_EQ(recommendation({}), "Take 13 patches (the default)");
}

TEST(ComparisonSummary, RecommendsTheFewestPatchesOfWhatIsThereAboutAsSoon) {
  // The order of the splits does not matter.
  const ComparisonSummary summary = summarize_comparison(
      comparison_of({{90, 0.029, 24, 12.0}, {20, 0.01, 24, 12.5}, {4, 0.005, 40, 20}}), "a");
  EXPECT_EQ(summary.recommended_patches, 20u);
  EXPECT_FALSE(contains(summary.recommendation, "If only decoding"));
}

TEST(ComparisonSummary, WeighsBytesByTheLine) {
  const Comparison comparison = comparison_of({{300, 0.3, 20, 10}, {30, 0.04, 24, 12}});
  EXPECT_EQ(summarize_comparison(comparison, "a", {.line_mbit = 50}).recommended_patches, 30u);
  const ComparisonSummary fast = summarize_comparison(comparison, "a", {.line_mbit = 100000});
  EXPECT_EQ(fast.recommended_patches, 300u);
  EXPECT_TRUE(contains(fast.rule, "100000 Mbit/s"));
}

TEST(ComparisonSummary, RecommendsNothingWithoutAChoice) {
  const ComparisonSummary one = summarize_comparison(comparison_of({{9, 0.01, 24, 12}}), "a");
  EXPECT_TRUE(contains(one.recommendation, "nothing can be recommended"));
  EXPECT_EQ(one.rule, "");
  const ComparisonSummary none = summarize_comparison(comparison_of({}), "a");
  EXPECT_FALSE(none.has_recommendation);
  EXPECT_EQ(none.headline, "");
}

TEST(ComparisonSummary, TellsOfThreadsThatAreSlowerThanOne) {
  const auto noise = [](const Measured& measured) {
    return summarize_comparison(comparison_of({measured}), "a").noise;
  };
  EXPECT_TRUE(noise({45, 0.02, 27, 16}).empty());
  EXPECT_TRUE(noise({1, 0, 27, 28}).empty());  // a single patch has no work for a second thread
  const std::vector<std::string> notes = noise({45, 0.02, 27, 28});
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_TRUE(contains(notes[0], "45 patches with cpu on 2 threads (28.0 ms instead of 27.0 ms)"));
  EXPECT_TRUE(contains(notes[1], "--repeat"));
  const Measured slower{45, 0.02, 27, 28};
  const ComparisonSummary many =
      summarize_comparison(comparison_of({slower, slower, slower, slower, slower, slower}), "a");
  EXPECT_TRUE(contains(many.noise[0], "instead of 27.0 ms); and 2 more. Either"));
}

TEST(ComparisonSummary, TellsOfTimesThatSwing) {
  Comparison comparison = comparison_of({{45, 0.02, 27, 16}, {90, 0.03, 27, 16}});
  comparison.splits[0].decode[1].timing = {16, 13, 40, 14, 25};
  std::vector<std::string> notes = summarize_comparison(comparison, "a").noise;
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_TRUE(
      contains(notes[0],
               "after 15 rounds the medians of 1 of 6 decoders may be off by over 25 %, most of all that of 45 "
               "patches with cpu on 2 threads."));
  // More rounds make the median certain.
  comparison.rounds = 150;
  EXPECT_TRUE(summarize_comparison(comparison, "a").noise.empty());
  comparison.rounds = 15;
  // One slow round of many is not noise, and libdraco's time for patches is in no sentence.
  comparison.splits[0].decode[1].timing = {16, 15, 40, 15.5, 17};
  comparison.splits[0].decode[2].timing = {16, 15, 40, 10, 20};
  EXPECT_TRUE(summarize_comparison(comparison, "a").noise.empty());
}

TEST(ComparisonSummary, TellsOfTooFewRounds) {
  Comparison comparison = comparison_of({{45, 0.02, 27, 16}});
  const auto noise = [&](int rounds) {
    comparison.rounds = rounds;
    return summarize_comparison(comparison, "a").noise;
  };
  EXPECT_TRUE(contains(noise(1).at(0), "only once"));
  EXPECT_TRUE(contains(noise(4).at(0), "only 4 rounds"));
  EXPECT_TRUE(noise(5).empty());
}

}  // namespace
}  // namespace psplit
