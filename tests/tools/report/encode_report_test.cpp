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

TEST(EncodeReport, SaysWhichBitsTheMeshChoseAndWhatTheyCost) {
  PrimitiveReport report;
  report.stored_as = StoredAs::kDraco;
  report.bytes = 16000;
  report.position_coding = {18, false, {0, 0, 0}, 1};
  StreamEntry stream;
  stream.stream_bytes = 16000;
  stream.point_count = 4000;
  stream.face_count = 9000;
  report.streams = {stream};
  EncodeDocumentOptions chosen;
  chosen.max_position_error = 0.001;
  const auto summary = [&](const std::vector<PrimitiveReport>& reports, const EncodeDocumentOptions& options) {
    return encode_summary(collect_rows(reports, {}, Log(Verbosity::kQuiet)), options);
  };
  // 4 bits more in 3 components of 4000 points are 6000 bytes, of which 93 % are stored.
  EXPECT_EQ(
      summary({report}, chosen),
      "mesh data 16.0 kB in 1 unsplit primitive; positions of 18 bits, about 54 % more bytes than with 14");
  EXPECT_EQ(summary({report}, {}), "mesh data 16.0 kB in 1 unsplit primitive");
  PrimitiveReport coarse = report;
  coarse.position_coding.bits = 10;
  EXPECT_EQ(
      summary({coarse}, chosen),
      "mesh data 16.0 kB in 1 unsplit primitive; positions of 10 bits, about 26 % fewer bytes than with 14");
  EXPECT_EQ(summary({report, coarse}, chosen),
            "mesh data 32.0 kB in 2 unsplit primitives; positions of 10 to 18 bits");
  // Stored once.
  coarse.repeated = true;
  EXPECT_EQ(
      summary({report, coarse}, chosen),
      "mesh data 16.0 kB in 1 unsplit primitive; positions of 18 bits, about 54 % more bytes than with 14");
}

}  // namespace
}  // namespace psplit
