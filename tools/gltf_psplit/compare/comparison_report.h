// The result of `compare`, as JSON and as text. page/html_report.h makes an HTML page of it.
#pragma once

#include <optional>

#include "tools/gltf_psplit/compare/asset_parts.h"
#include "tools/gltf_psplit/compare/comparison.h"
#include "tools/gltf_psplit/compare/comparison_summary.h"

namespace psplit {

// The machine and the versions that something was measured with.
struct Environment {
  std::string cpu;                                 // the model
  int threads = 1;                                 // hardware threads
  std::string gpu;                                 // empty if there is none that this build can use
  std::string psplit, draco, meshoptimizer, zstd;  // versions
  std::string brotli;                              // version; empty if this build has none
  int meshopt_codec = 0;                           // version of meshoptimizer's attribute codec
  std::string compiler;                            // that built psplit
  std::string command_line;                        // without the folders of files
  std::string date;                                // UTC, such as 2026-01-31 12:00
};

// `version` and `command_line` describe the command (Session).
Environment describe_environment(const std::string& version, const std::string& command_line);

struct PatchPicture {
  std::vector<uint8_t> png;  // empty if nothing could be drawn
  uint64_t patches = 0;
};

struct ComparisonReport {
  std::string input;  // the name of the file, without its folder
  ComparisonOptions options;
  LoadingModel loading;
  Comparison comparison;
  std::optional<AssetParts> asset;  // nothing if the input is compressed already
  Environment environment;
  PatchPicture picture;  // only for pages
};

// The sentences that text, JSON and page begin with.
ComparisonSummary summarize(const ComparisonReport& report);

Json to_json(const ComparisonReport& report);
// `wide`: with all columns; otherwise with the columns that fit into 100 characters.
std::string to_text(const ComparisonReport& report, bool wide = true);

}  // namespace psplit
