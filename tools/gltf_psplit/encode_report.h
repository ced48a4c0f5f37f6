// What became of an asset, as `encode` and `batch` say it: rows of JSON, and lines of the log.
#pragma once

#include <span>

#include "gltf_ext/convert.h"
#include "tools/gltf_psplit/messages.h"
#include "tools/gltf_psplit/patch_summary.h"

namespace psplit {

// One primitive's row of the report, or the sum of all rows.
struct EncodeRow {
  uint64_t input_faces = 0, input_points = 0;
  PatchSummary summary;
  EncodeStatistics statistics;

  EncodeRow& operator+=(const EncodeRow& other) {
    input_faces += other.input_faces;
    input_points += other.input_points;
    summary += other.summary;
    statistics.merged_points += other.statistics.merged_points;
    statistics.dropped_faces += other.statistics.dropped_faces;
    statistics.dropped_points += other.statistics.dropped_points;
    statistics.residue_faces += other.statistics.residue_faces;
    statistics.partition_ms += other.statistics.partition_ms;
    statistics.encode_ms += other.statistics.encode_ms;
    statistics.verify_ms += other.statistics.verify_ms;
    return *this;
  }
};

void append_row(Json& object, const EncodeRow& row);
std::string row_text(const EncodeRow& row);

// An asset: the sum of its primitives, a row of JSON for each, and how many of them are in patches now.
struct EncodeResult {
  EncodeRow total;
  Json primitives = Json::array();
  size_t split_count = 0;
};
EncodeResult collect_rows(std::span<const PrimitiveReport> reports, const Log& log);

void log_changes(const EncodeStatistics& statistics, const Log& log);

}  // namespace psplit
