// The result of `compare`, as JSON and as text. page/html_report.h makes an HTML page of it.
#pragma once

#include <optional>

#include "tools/gltf_psplit/compare/asset_parts.h"
#include "tools/gltf_psplit/compare/comparison.h"
#include "tools/gltf_psplit/compare/comparison_summary.h"
#include "tools/gltf_psplit/compare/environment.h"

namespace psplit {

struct PatchPicture {
  std::vector<uint8_t> png;  // empty if nothing could be drawn
  uint64_t patches = 0;
};

struct ComparisonReport {
  std::string input;  // the name of the file, without its folder
  ComparisonOptions options;
  Comparison comparison;
  std::optional<AssetParts> asset;  // nothing if the input is compressed already
  Environment environment;
  PatchPicture picture;  // only for pages
};

// The sentences that text, JSON and page begin with.
ComparisonSummary summarize(const ComparisonReport& report);

Json to_json(const ComparisonReport& report);
// `wide`: with all columns; otherwise with those that fit into 100 characters.
std::string to_text(const ComparisonReport& report, bool wide = true);

// The versions of all libraries: "psplit 0.1.0 (g++ 12.2.0), libdraco ..."
std::string versions_text(const Environment& environment);

}  // namespace psplit
