#include "tools/gltf_psplit/batch/batch_summary.h"

#include <algorithm>
#include <vector>

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

}  // namespace

std::string batch_summary(const std::string& folder, std::span<const BatchOutcome> outcomes, double wall_ms) {
  size_t failed = 0, up_to_date = 0;
  uint64_t patches = 0;
  AssetSizes sizes;
  for (const BatchOutcome& outcome : outcomes) {
    failed += outcome.status.ok() ? 0 : 1;
    up_to_date += outcome.up_to_date ? 1 : 0;
    if (!outcome.status.ok() || outcome.up_to_date) continue;
    patches += outcome.patches;
    sizes += outcome.sizes;
  }
  const size_t encoded = outcomes.size() - failed - up_to_date;
  std::string text = folder + ": " + counted(outcomes.size(), "asset") + ", " + with_separators(encoded) +
                     " encoded, " + with_separators(up_to_date) + " up to date, " + with_separators(failed) +
                     " failed; " + as_duration(wall_ms) + "\n";
  if (encoded == 0 && failed == 0) text += "nothing was encoded\n";
  if (encoded > 0) text += sizes_text(sizes) + "; " + counted(patches, "patch") + "\n";
  return text + slowest_text(outcomes) + failures_text(outcomes, failed);
}

}  // namespace psplit
