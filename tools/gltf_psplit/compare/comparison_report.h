// What `compare` says, as JSON and as a table for people; as a page it is html_report.h's.
#pragma once

#include <optional>

#include "tools/gltf_psplit/compare/asset_parts.h"
#include "tools/gltf_psplit/compare/comparison.h"
#include "tools/gltf_psplit/compare/environment.h"

namespace psplit {

struct PatchPicture {
  std::vector<uint8_t> png;  // empty where nothing could be drawn
  uint64_t patches = 0;
};

struct ComparisonReport {
  std::string input;  // its name, without its folder
  ComparisonOptions options;
  Comparison comparison;
  std::optional<AssetParts> asset;  // nothing where the input is compressed already
  Environment environment;
  PatchPicture picture;  // drawn for pages only
};

Json to_json(const ComparisonReport& report);
// In a table of 100 columns, or with all columns.
std::string to_text(const ComparisonReport& report, bool wide = true);

// "g++ 12.2.0; psplit 0.1.0, ..." for people: what of the environment is versions.
std::string versions_text(const Environment& environment);

}  // namespace psplit
