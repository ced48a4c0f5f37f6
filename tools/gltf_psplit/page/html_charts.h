// The charts of the page of `compare`.
#pragma once

#include <string>

#include "tools/gltf_psplit/compare/comparison_figures.h"

namespace psplit {

// <figure> after <figure>.
std::string comparison_charts(const ComparisonFigures& figures);

}  // namespace psplit
