#include "tools/gltf_psplit/report/progress.h"

#include <gtest/gtest.h>

#include "tools/gltf_psplit/report/log.h"

namespace psplit {
namespace {

WorkDone steps(uint64_t done, uint64_t total, const std::string& noun = "patch") {
  WorkDone work;
  work.done = done;
  work.total = total;
  work.noun = noun;
  return work;
}

TEST(Progress, ShowsABarOnlyWhereThereAreSteps) {
  EXPECT_EQ(progress_line("encoding", steps(0, 0), 1.25), "encoding 1.2 s");
  EXPECT_EQ(progress_line("encoding", steps(0, 1), 2), "encoding 2.0 s");
  EXPECT_EQ(progress_line("encoding", steps(1, 2), 3),
            "encoding [##########..........] 1 of 2 patches, 3 s left, 3.0 s");
  EXPECT_EQ(progress_line("encoding", steps(5, 2), 9), "encoding [####################] 5 of 2 patches, 9.0 s");
}

TEST(Progress, SaysKOfNAndARate) {
  EXPECT_EQ(progress_line("decoding", steps(1200, 4800), 2),
            "decoding [#####...............] 1,200 of 4,800 patches, 6 s left, 600 patches/s");
  WorkDone faces = steps(120, 450);
  faces.amount = 3000000;
  faces.amount_noun = "face";
  EXPECT_EQ(progress_line("encoding", faces, 2.5),
            "encoding [#####...............] 120 of 450 patches, 7 s left, 1,200,000 faces/s");
  WorkDone bytes = steps(3, 12, "asset");
  bytes.amount = 90400000;
  bytes.amount_noun = "byte";
  EXPECT_EQ(progress_line("encoding", bytes, 2),
            "encoding [#####...............] 3 of 12 assets, 6 s left, 45.2 MB/s, 2.0 s");
  // There is no rate before anything is done.
  EXPECT_EQ(progress_line("encoding", steps(0, 12, "asset"), 2),
            "encoding [....................] 0 of 12 assets, 2.0 s");
}

TEST(Progress, SaysHowMuchTimeIsLeft) {
  EXPECT_EQ(progress_line("reading", steps(1000000, 4000000, "byte"), 2),
            "reading [#####...............] 1.00 MB of 4.00 MB, 6 s left, 500 kB/s, 2.0 s");
  EXPECT_TRUE(progress_line("encoding", steps(10, 100), 20).find("3 min left") != std::string::npos);
  EXPECT_TRUE(progress_line("encoding", steps(10, 1000), 100).find("3 h left") != std::string::npos);
  // A pipe does not tell its size.
  EXPECT_EQ(progress_line("reading", steps(1000000, 0, "byte"), 2), "reading 500 kB/s, 2.0 s");
}

TEST(Progress, NamesTheStage) {
  WorkDone work = steps(0, 0);
  work.stage = "cutting 1,000,000 faces";
  EXPECT_EQ(progress_line("encoding", work, 3), "encoding cutting 1,000,000 faces, 3.0 s");
}

TEST(Progress, StaysInOneLine) {
  WorkDone work = steps(123456, 1234567890);
  work.stage = "a stage whose name nobody could read in the time it takes";
  EXPECT_LE(progress_line("encoding", work, 1e6).size(), 79u);
}

TEST(Progress, IsNotDrawnWhereNobodyLooks) {
  ProgressBar bar("encoding", Log(Verbosity::kQuiet));
  EXPECT_FALSE(bar.callback());
  bar.show(steps(1, 2));
}

}  // namespace
}  // namespace psplit
