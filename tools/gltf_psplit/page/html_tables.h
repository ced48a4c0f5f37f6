// The tables on the page of `compare`.
#pragma once

#include <string>
#include <vector>

#include "tools/gltf_psplit/compare/comparison_figures.h"
#include "tools/gltf_psplit/compare/comparison_summary.h"

namespace psplit {

// A table whose first `left_columns` columns are text. The first cell of each row is its header. In a window
// that is too narrow, the table scrolls sideways.
std::string html_table(const std::string& id, const std::string& caption,
                       const std::vector<std::string>& header,
                       const std::vector<std::vector<std::string>>& rows, size_t left_columns = 1);

// Bytes of the whole asset with its textures, uncompressed and compressed.
std::string asset_table(const AssetParts& parts, const ComparisonFigures& figures,
                        const ComparisonSummary& summary);

// The tables of all decoders, all sizes and all stages.
std::string comparison_tables(const ComparisonFigures& figures);

}  // namespace psplit
