#include "tools/gltf_psplit/batch/batch_report.h"

#include <gtest/gtest.h>

namespace psplit {
namespace {

BatchOutcome encoded(const std::string& input, double wall_ms) {
  BatchOutcome outcome{.input = input, .sizes = {{3000000, 0}, {300000, 0}}, .wall_ms = wall_ms};
  outcome.result.total.summary.patches = 5;
  return outcome;
}
const BatchOutcome kUpToDate{.input = "c.glb", .up_to_date = true};

TEST(BatchReport, CountsAndAddsUp) {
  const std::vector<BatchOutcome> outcomes = {encoded("a.glb", 20), encoded("b.glb", 1500), kUpToDate};
  EXPECT_EQ(summary_text({.folder = "out", .wall_ms = 1600, .outcomes = outcomes}),
            "out: 3 assets, 2 encoded, 1 up to date, 0 failed; 1.60 s\n"
            "600 kB from 6.00 MB (10.0 %); 10 patches\n"
            "slowest: b.glb 1.50 s, a.glb 20.0 ms\n");
}

TEST(BatchReport, SaysThatNothingWasDone) {
  EXPECT_EQ(summary_text({.folder = "out", .wall_ms = 1600, .outcomes = {&kUpToDate, 1}}),
            "out: 1 asset, 0 encoded, 1 up to date, 0 failed; 1.60 s\n"
            "nothing was encoded\n");
}

TEST(BatchReport, GivesReasonsOfFailuresAndAnEndToThem) {
  std::vector<BatchOutcome> outcomes;
  for (int i = 0; i < 23; ++i)
    outcomes.push_back({.input = "x", .status = invalid_input("broken", {.file = "x.glb"})});
  const std::string text = summary_text({.folder = "out", .wall_ms = 1, .outcomes = outcomes});
  EXPECT_EQ(text.find("out: 23 assets, 0 encoded, 0 up to date, 23 failed; 1.0 ms\nfailed: x.glb: broken\n"),
            0u)
      << text;
  EXPECT_TRUE(text.ends_with("failed: x.glb: broken\nand 3 more failures; the report lists all\n")) << text;
}

}  // namespace
}  // namespace psplit
