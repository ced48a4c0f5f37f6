// The charts on the page of `compare`.
#pragma once

#include <string>

#include "tools/gltf_psplit/compare/comparison_figures.h"

namespace psplit {

// A sequence of <figure> elements.
std::string comparison_charts(const ComparisonFigures& figures);

}  // namespace psplit
