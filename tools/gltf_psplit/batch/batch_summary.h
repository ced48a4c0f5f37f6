// What `batch` did, for people: its JSON report has every asset.
#pragma once

#include <span>
#include <string>

#include "src/status.h"
#include "tools/gltf_psplit/report/asset_bytes.h"

namespace psplit {

// What became of one asset.
struct BatchOutcome {
  std::string input;
  Status status;
  bool up_to_date = false;  // and so nothing of what follows
  AssetSizes sizes;
  uint64_t patches = 0;
  double wall_ms = 0;
};

// Counts, bytes in and out, the slowest assets, and each failure with its reason; several lines.
std::string batch_summary(const std::string& folder, std::span<const BatchOutcome> outcomes, double wall_ms);

}  // namespace psplit
