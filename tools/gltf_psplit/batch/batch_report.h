// What `batch` reports: a summary for people, and a JSON report that lists every asset.
#pragma once

#include <span>
#include <string>

#include "gltf_ext/document/write_report.h"
#include "src/status.h"
#include "tools/gltf_psplit/report/asset_bytes.h"
#include "tools/gltf_psplit/report/encode_report.h"

namespace psplit {

// The result of one asset.
struct BatchOutcome {
  std::string input{}, output{};
  Status status{};
  bool up_to_date = false;  // if so, the members below are unset
  EncodeResult result{};
  WriteReport written{};
  AssetSizes sizes{};
  double wall_ms = 0;
};

struct BatchReport {
  std::string folder{};
  bool verified = true;
  int threads = 1;
  double wall_ms = 0;
  std::span<const BatchOutcome> outcomes{};

  size_t failed() const;
  size_t up_to_date() const;
  size_t encoded() const { return outcomes.size() - failed() - up_to_date(); }
};

// Several lines: counts, bytes in and out, the slowest assets, and failures with their reasons.
std::string summary_text(const BatchReport& report);
Json to_json(const BatchReport& report);

}  // namespace psplit
