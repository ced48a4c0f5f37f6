#include "tools/gltf_psplit/batch/batch_summary.h"

#include <gtest/gtest.h>

namespace psplit {
namespace {

BatchOutcome encoded(const std::string& input, double wall_ms) {
  return {input, {}, false, {{3000000, 0}, {300000, 0}}, 5, wall_ms};
}

TEST(BatchSummary, CountsAndAddsUp) {
  BatchOutcome up_to_date{.input = "c.glb", .status = {}, .up_to_date = true, .sizes = {}};
  const std::vector<BatchOutcome> outcomes = {encoded("a.glb", 20), encoded("b.glb", 1500), up_to_date};
  EXPECT_EQ(batch_summary("out", outcomes, 1600),
            "out: 3 assets, 2 encoded, 1 up to date, 0 failed; 1.60 s\n"
            "600 kB from 6.00 MB (10.0 %); 10 patches\n"
            "slowest: b.glb 1.50 s, a.glb 20.0 ms\n");
}

TEST(BatchSummary, SaysThatNothingWasDone) {
  BatchOutcome up_to_date{.input = "c.glb", .status = {}, .up_to_date = true, .sizes = {}};
  EXPECT_EQ(batch_summary("out", {&up_to_date, 1}, 1600),
            "out: 1 asset, 0 encoded, 1 up to date, 0 failed; 1.60 s\n"
            "nothing was encoded\n");
}

TEST(BatchSummary, GivesReasonsOfFailuresAndAnEndToThem) {
  std::vector<BatchOutcome> outcomes;
  for (int i = 0; i < 23; ++i)
    outcomes.push_back({.input = "x", .status = invalid_input("broken", {.file = "x.glb"}), .sizes = {}});
  const std::string text = batch_summary("out", outcomes, 1);
  EXPECT_EQ(text.find("out: 23 assets, 0 encoded, 0 up to date, 23 failed; 1.0 ms\nfailed: x.glb: broken\n"),
            0u)
      << text;
  EXPECT_TRUE(text.ends_with("failed: x.glb: broken\nand 3 more failures; the report lists all\n")) << text;
}

}  // namespace
}  // namespace psplit
