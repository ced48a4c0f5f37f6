#include "tools/gltf_psplit/encode_report.h"

namespace psplit {

void append_row(Json& object, const EncodeRow& row) {
  object["input"] = {{"faces", row.input_faces}, {"points", row.input_points}};
  append_summary(object, row.summary);
  object["merged_points"] = row.statistics.merged_points;
  object["dropped_faces"] = row.statistics.dropped_faces;
  object["dropped_points"] = row.statistics.dropped_points;
  object["residue_faces"] = row.statistics.residue_faces;
  object["partition_ms"] = row.statistics.partition_ms;
  object["encode_ms"] = row.statistics.encode_ms;
  object["verify_ms"] = row.statistics.verify_ms;
}

std::string row_text(const EncodeRow& row) {
  const PatchSummary& summary = row.summary;
  const uint64_t map_bytes = summary.directory_bytes + summary.stitch_bytes;
  const double map_share =
      summary.total_bytes == 0 ? 0 : static_cast<double>(map_bytes) / static_cast<double>(summary.total_bytes);
  return counted(summary.patches, "patch") + ", " + counted(summary.faces, "face") + ", " +
         counted(summary.points, "point") + ", " + counted(summary.total_bytes, "byte") + " (" +
         with_decimals(summary.bits_per_point(), 2) + " bits a point; overhead: replication " +
         as_share(summary.replication()) + ", directory and stitch map " + as_share(map_share) +
         "); partition " + as_duration(row.statistics.partition_ms) + ", all of encoding " +
         as_duration(row.statistics.encode_ms) + ", verification " + as_duration(row.statistics.verify_ms);
}

EncodeResult collect_rows(std::span<const PrimitiveReport> reports, const Log& log) {
  EncodeResult result;
  for (const PrimitiveReport& report : reports) {
    Json object{{"mesh", report.id.mesh}, {"primitive", report.id.primitive}};
    if (report.skipped.empty()) {
      const EncodeRow row{report.faces, report.points,
                          summarize_streams(report.streams, report.has_residue, report.bytes),
                          report.statistics};
      append_row(object, row);
      result.total += row;
      ++result.split_count;
      log.detail(describe_place(report.id.mesh, report.id.primitive) + ": " + row_text(row));
    } else {
      object["skipped"] = report.skipped;
    }
    if (!report.warnings.empty()) object["warnings"] = report.warnings;
    result.primitives.push_back(std::move(object));
  }
  return result;
}

void log_changes(const EncodeStatistics& statistics, const Log& log) {
  if (statistics.merged_points > 0) log.note("merged " + counted(statistics.merged_points, "duplicate point"));
  if (statistics.dropped_faces + statistics.dropped_points > 0)
    log.note("dropped " + counted(statistics.dropped_faces, "degenerate face") + " and " +
             counted(statistics.dropped_points, "unused point"));
}

}  // namespace psplit
