#include "tools/gltf_psplit/batch/batch_report.h"

#include <algorithm>
#include <vector>

#include "tools/gltf_psplit/files/asset_output.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

constexpr size_t kSlowest = 3;
constexpr size_t kFailures = 20;

std::string slowest_text(std::span<const BatchOutcome> outcomes) {
  std::vector<const BatchOutcome*> slowest;
  for (const BatchOutcome& outcome : outcomes)
    if (outcome.status.ok() && !outcome.up_to_date) slowest.push_back(&outcome);
  if (slowest.size() < 2) return "";
  std::ranges::stable_sort(slowest, std::greater<>(), &BatchOutcome::wall_ms);
  std::string text = "slowest: ";
  for (size_t i = 0; i < std::min(kSlowest, slowest.size()); ++i)
    text += (i == 0 ? "" : ", ") + slowest[i]->input + " " + as_duration(slowest[i]->wall_ms);
  return text + "\n";
}

std::string failures_text(std::span<const BatchOutcome> outcomes, size_t failed) {
  std::string text;
  size_t listed = 0;
  for (const BatchOutcome& outcome : outcomes)
    if (!outcome.status.ok() && listed++ < kFailures) text += "failed: " + outcome.status.to_string() + "\n";
  if (failed > kFailures)
    text += "and " + counted(failed - kFailures, "more failure") + "; the report lists all\n";
  return text;
}

Json asset_json(const BatchOutcome& outcome) {
  Json asset{{"input", outcome.input}, {"output", outcome.output}};
  asset["status"] = !outcome.status.ok() ? "failed" : outcome.up_to_date ? "up to date" : "encoded";
  if (!outcome.status.ok()) {
    asset["error"] = {{"code", static_cast<int>(outcome.status.code())},
                      {"message", outcome.status.to_string()}};
  } else if (!outcome.up_to_date) {
    asset["files"] = sizes_json(outcome.sizes);
    asset["geometry"] = {{"input_bytes", outcome.result.geometry.input},
                         {"output_bytes", outcome.result.geometry.output}};
    append_row(asset["total"], outcome.result.total);
    append_written(asset, outcome.written);
    asset["primitives"] = outcome.result.primitives;
  }
  asset["wall_ms"] = outcome.wall_ms;
  return asset;
}

// The sums over all assets that were encoded.
struct Sums {
  EncodeRow total;
  AssetSizes sizes;
};

Sums sum_of(std::span<const BatchOutcome> outcomes) {
  Sums sums;
  for (const BatchOutcome& outcome : outcomes) {
    if (!outcome.status.ok() || outcome.up_to_date) continue;
    sums.total += outcome.result.total;
    sums.sizes += outcome.sizes;
  }
  return sums;
}

}  // namespace

size_t BatchReport::failed() const {
  return static_cast<size_t>(std::ranges::count_if(outcomes, [](const auto& o) { return !o.status.ok(); }));
}
size_t BatchReport::up_to_date() const {
  return static_cast<size_t>(std::ranges::count(outcomes, true, &BatchOutcome::up_to_date));
}

std::string summary_text(const BatchReport& report) {
  const Sums sums = sum_of(report.outcomes);
  std::string text = report.folder + ": " + counted(report.outcomes.size(), "asset") + ", " +
                     with_separators(report.encoded()) + " encoded, " + with_separators(report.up_to_date()) +
                     " up to date, " + with_separators(report.failed()) + " failed; " +
                     as_duration(report.wall_ms) + "\n";
  if (report.encoded() == 0 && report.failed() == 0) text += "nothing was encoded\n";
  if (report.encoded() > 0)
    text += sizes_text(sums.sizes) + "; " + counted(sums.total.summary.patches, "patch") + "\n";
  return text + slowest_text(report.outcomes) + failures_text(report.outcomes, report.failed());
}

Json to_json(const BatchReport& report) {
  const Sums sums = sum_of(report.outcomes);
  Json result{{"folder", report.folder},     {"verified", report.verified},       {"threads", report.threads},
              {"encoded", report.encoded()}, {"up_to_date", report.up_to_date()}, {"failed", report.failed()},
              {"wall_ms", report.wall_ms},   {"files", sizes_json(sums.sizes)}};
  append_row(result["total"], sums.total);
  result["assets"] = Json::array();
  for (const BatchOutcome& outcome : report.outcomes) result["assets"].push_back(asset_json(outcome));
  return result;
}

}  // namespace psplit
