// The summary that `batch` prints. Its JSON report lists every asset.
#pragma once

#include <span>
#include <string>

#include "src/status.h"
#include "tools/gltf_psplit/report/asset_bytes.h"

namespace psplit {

// The result of one asset.
struct BatchOutcome {
  std::string input;
  Status status;
  bool up_to_date = false;  // if so, the members below are unset
  AssetSizes sizes;
  uint64_t patches = 0;
  double wall_ms = 0;
};

// Several lines: counts, bytes in and out, the slowest assets, and failures with their reasons.
std::string batch_summary(const std::string& folder, std::span<const BatchOutcome> outcomes, double wall_ms);

}  // namespace psplit
