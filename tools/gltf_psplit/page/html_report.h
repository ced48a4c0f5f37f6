// The result of `compare` as an HTML page: one file without scripts, which loads nothing from a network.
#pragma once

#include <string>
#include <vector>

#include "tools/gltf_psplit/compare/comparison_figures.h"
#include "tools/gltf_psplit/compare/comparison_report.h"
#include "tools/gltf_psplit/compare/comparison_summary.h"

namespace psplit {

// Deterministic. Text that comes from files and from the machine is escaped.
std::string to_html(const ComparisonReport& report);

// The chart that sums up the page: bytes and times of everything that was measured.
std::string chart_of_size_and_speed(const ComparisonFigures& figures);

// The other charts, a sequence of <figure> elements.
std::string comparison_charts(const ComparisonFigures& figures);

// Bytes of the whole asset with its textures, uncompressed and compressed.
std::string asset_table(const AssetParts& parts, const ComparisonFigures& figures,
                        const ComparisonSummary& summary);

// The tables of all decoders, all sizes and all stages.
std::string comparison_tables(const ComparisonFigures& figures);

}  // namespace psplit
