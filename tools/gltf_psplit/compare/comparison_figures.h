// Ratios, units and names for the measurements of a comparison. Tables and charts share them.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tools/gltf_psplit/compare/comparison_report.h"

namespace psplit {

// Refers to the report, which must outlive it.
class ComparisonFigures {
 public:
  explicit ComparisonFigures(const ComparisonReport& its_report)
      : report(its_report), comparison(its_report.comparison), base(its_report.comparison.stock) {}

  double bits_per_point(uint64_t bytes) const;
  double million_triangles_a_second(double ms) const;
  double speedup(double ms) const;
  std::string over_base(uint64_t bytes) const;  // "+2.0 %"
  double percent_of_base(uint64_t bytes) const;
  bool has_condensed() const;  // patches
  std::string base_name() const { return stock_name(base); }
  // Rows of meshoptimizer with what compresses its bytes once more: "", "zstd", "brotli".
  std::vector<std::pair<std::string, const MeshoptRow*>> meshopt_rows() const;
  // "meshoptimizer 0.18"
  std::string meshopt_name() const { return "meshoptimizer " + report.environment.meshoptimizer; }

  static std::string stock_name(const StockRow& row);     // "stock Draco, speed 5"
  static std::string patches_name(const SplitRow& row);   // "45 patches", "45 condensed patches"
  static std::string decoder_name(const DecodeRow& row);  // "cpu, 2 threads"
  static std::string ms_text(double ms);                  // with about three digits
  static std::string median_text(const Timing& timing);   // "~12.3" if the time is noisy

  const ComparisonReport& report;
  const Comparison& comparison;
  const StockRow& base;  // all ratios refer to it
};

}  // namespace psplit
