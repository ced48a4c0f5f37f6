#include "tools/gltf_psplit/batch/batch_report.h"

#include <gtest/gtest.h>

#include "system/io_error.h"

namespace psplit {
namespace {

BatchOutcome encoded(const std::string& input, double wall_ms) {
  BatchOutcome outcome{.input = input, .sizes = {{3000000, 0}, {300000, 0}}, .wall_ms = wall_ms};
  outcome.result.total.summary.patches = 5;
  return outcome;
}
const BatchOutcome kUpToDate{.input = "c.glb", .up_to_date = true};

BatchTally tally_of(const std::vector<BatchOutcome>& outcomes) {
  BatchTally tally(BatchVerb::kEncode);
  for (BatchOutcome outcome : outcomes) {
    if (!outcome.up_to_date) outcome.figures = figures_of(outcome, BatchVerb::kEncode);
    tally.add(to_json(std::move(outcome), BatchVerb::kEncode));
  }
  return tally;
}

TEST(BatchReport, CountsAndAddsUp) {
  const BatchTally tally = tally_of({encoded("a.glb", 20), encoded("b.glb", 1500), kUpToDate});
  EXPECT_EQ(tally.summary("out", 1600),
            "out: 3 assets, 2 encoded, 1 up to date, 0 failed; 1.60 s\n"
            "600 kB from 6.00 MB (10.0 %); 10 patches\n"
            "slowest: b.glb 1.50 s, a.glb 20.0 ms\n");
  EXPECT_TRUE(tally.status(0).ok());
  EXPECT_EQ(tally_of({kUpToDate}).summary("out", 1600),
            "out: 1 asset, 0 encoded, 1 up to date, 0 failed; 1.60 s\n"
            "nothing was encoded\n");
}

TEST(BatchReport, TotalsCountWhatWasUpToDate) {
  BatchOutcome known = kUpToDate;
  known.figures = figures_of(encoded("c.glb", 1), BatchVerb::kEncode);
  EXPECT_EQ(tally_of({encoded("a.glb", 20), known}).summary("out", 0),
            "out: 2 assets, 1 encoded, 1 up to date, 0 failed\n"
            "600 kB from 6.00 MB (10.0 %); 10 patches\n");
  EXPECT_EQ(
      tally_of({encoded("a.glb", 20), known, kUpToDate}).line("shard 0/2 of out", 1600),
      "shard 0/2 of out: 3 assets, 1 encoded, 2 up to date, 0 failed; 1.60 s; 600 kB from 6.00 MB (10.0 %); "
      "10 patches");
}

TEST(BatchReport, GivesReasonsOfFailuresAndAnEndToThem) {
  const std::vector<BatchOutcome> outcomes(
      23, {.input = "x", .status = invalid_input("broken", {.file = "x.glb"})});
  const std::string text = tally_of(outcomes).summary("out", 1);
  EXPECT_EQ(text.find("out: 23 assets, 0 encoded, 0 up to date, 23 failed; 1.0 ms\nfailed: x.glb: broken\n"),
            0u)
      << text;
  EXPECT_TRUE(text.ends_with("failed: x.glb: broken\nand 3 more failures; the report lists all\n")) << text;
}

// The rows pass through JSON, and no sum is lost on the way.
TEST(BatchReport, RowsKeepAllThatIsSummed) {
  BatchOutcome outcome = encoded("a.glb", 1);
  PatchSummary& summary = outcome.result.total.summary;
  summary.faces = 100;
  summary.points = 60;
  summary.references = 6;
  summary.largest_patch_faces = 30;
  summary.patch_faces = 90;
  summary.payload_bytes = 50;
  summary.total_bytes = 70;
  outcome.result.total.input_faces = 101;
  outcome.result.total.statistics.dropped_faces = 1;
  Json one;
  append_row(one, outcome.result.total);
  EXPECT_EQ(tally_of({outcome}).to_json()["total"], one);
  EncodeRow two = outcome.result.total;
  two += outcome.result.total;
  Json sum;
  append_row(sum, two);
  EXPECT_EQ(tally_of({outcome, outcome}).to_json()["total"], sum);
}

TEST(BatchReport, WhatMayPassDecidesTheCode) {
  const BatchOutcome bad{.input = "x", .status = invalid_input("broken")};
  const BatchOutcome full{.input = "y", .status = may_pass("cannot write: no space")};
  EXPECT_EQ(tally_of({bad, full}).status(0).code(), StatusCode::kMayPass);
  EXPECT_EQ(tally_of({bad, full}).status(9).code(), StatusCode::kMayPass);
  const BatchOutcome large{.input = "z", .status = out_of_memory("out of memory")};
  EXPECT_EQ(tally_of({bad, large}).status(9).code(), StatusCode::kMayPass);
  EXPECT_EQ(tally_of({bad, large}).to_json()["may_pass"], 1);
  EXPECT_EQ(tally_of({bad, bad}).status(1).code(), StatusCode::kInvalidInput);
  EXPECT_TRUE(tally_of({bad, bad}).status(2).ok());
}

}  // namespace
}  // namespace psplit
