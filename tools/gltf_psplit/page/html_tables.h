// The tables of the page of `compare`.
#pragma once

#include <string>
#include <vector>

#include "tools/gltf_psplit/compare/comparison_figures.h"
#include "tools/gltf_psplit/compare/comparison_summary.h"

namespace psplit {

// A table whose first `left_columns` columns are text; a row's first cell is its header. It scrolls sideways in
// a window that is too narrow for it.
std::string html_table(const std::string& id, const std::string& caption,
                       const std::vector<std::string>& header,
                       const std::vector<std::vector<std::string>>& rows, size_t left_columns = 1);

// The whole asset with its textures, as it is and compressed.
std::string asset_table(const AssetParts& parts, const ComparisonFigures& figures,
                        const ComparisonSummary& summary);

// Every decoder, every size, every stage.
std::string comparison_tables(const ComparisonFigures& figures);

}  // namespace psplit
