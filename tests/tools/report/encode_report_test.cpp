#include "tools/gltf_psplit/report/encode_report.h"

#include <gtest/gtest.h>

namespace psplit {
namespace {

TEST(EncodeReport, ChangesAreCountedByKind) {
  EncodeStatistics statistics;
  EXPECT_EQ(changes_text(statistics), "");
  statistics.merged_points = 12;
  statistics.dropped_faces = 1;
  statistics.dropped_points = 2000;
  statistics.residue_faces = 3;
  EXPECT_EQ(changes_text(statistics),
            "merged 12 duplicate points, dropped 1 degenerate face, dropped 2,000 unused points, "
            "kept 3 degenerate faces");
}

}  // namespace
}  // namespace psplit
