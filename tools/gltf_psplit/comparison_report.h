// What `compare` says, as JSON and as a table for people; as a page it is html_report.h's.
#pragma once

#include "tools/gltf_psplit/comparison.h"
#include "tools/gltf_psplit/environment.h"

namespace psplit {

struct PatchPicture {
  std::vector<uint8_t> png;  // empty where nothing could be drawn
  uint64_t patches = 0;
};

struct ComparisonReport {
  std::string input;  // its name
  ComparisonOptions options;
  Comparison comparison;
  Environment environment;
  PatchPicture picture;  // drawn for pages only
};

Json to_json(const ComparisonReport& report);
std::string to_text(const ComparisonReport& report);

// "g++ 12.2.0; psplit 0.1.0, ..." for people: what of the environment is versions.
std::string versions_text(const Environment& environment);

}  // namespace psplit
