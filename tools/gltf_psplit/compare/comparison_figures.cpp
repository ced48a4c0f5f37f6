#include "tools/gltf_psplit/compare/comparison_figures.h"

#include <algorithm>

#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

constexpr double kLeastMs = 1e-6;  // the least time, in case the clock did not advance

}  // namespace

double ComparisonFigures::bits_per_point(uint64_t bytes) const {
  return comparison.points == 0 ? 0 : 8 * static_cast<double>(bytes) / static_cast<double>(comparison.points);
}
double ComparisonFigures::million_triangles_a_second(double ms) const {
  return static_cast<double>(comparison.faces) / std::max(ms, kLeastMs) / 1000;
}
double ComparisonFigures::speedup(double ms) const { return base.decode.median_ms / std::max(ms, kLeastMs); }
double ComparisonFigures::percent_of_base(uint64_t bytes) const {
  return 100 * static_cast<double>(bytes) / static_cast<double>(std::max<uint64_t>(base.bytes, 1));
}
std::string ComparisonFigures::over_base(uint64_t bytes) const {
  return as_percent(percent_of_base(bytes) / 100 - 1);
}
bool ComparisonFigures::has_condensed() const {
  return std::ranges::any_of(comparison.splits, [](const SplitRow& row) { return row.rule.condense; });
}
std::vector<std::pair<std::string, const MeshoptRow*>> ComparisonFigures::meshopt_rows() const {
  std::vector<std::pair<std::string, const MeshoptRow*>> rows{{"", &comparison.meshopt_plain},
                                                              {"zstd", &comparison.meshopt}};
  if (comparison.meshopt_brotli) rows.emplace_back("brotli", &*comparison.meshopt_brotli);
  return rows;
}
std::string ComparisonFigures::stock_name(const StockRow& row) {
  return "stock Draco, speed " + std::to_string(row.speed);
}
std::string ComparisonFigures::patches_name(const SplitRow& row) {
  return counted(row.summary.patches, row.rule.condense ? "condensed patch" : "patch");
}
std::string ComparisonFigures::decoder_name(const DecodeRow& row) {
  return row.backend + ", " + counted(static_cast<uint64_t>(row.threads), "thread");
}
std::string ComparisonFigures::ms_text(double ms) {
  return with_decimals(ms, ms < 0.1 ? 4 : ms < 1 ? 3 : ms < 100 ? 2 : 1);
}
std::string ComparisonFigures::median_text(const Timing& timing) {
  return (is_noisy(timing) ? "~" : "") + ms_text(timing.median_ms);
}

}  // namespace psplit
