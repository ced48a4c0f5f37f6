// The charts on the page of `compare`.
#pragma once

#include <string>

#include "tools/gltf_psplit/compare/comparison_figures.h"

namespace psplit {

// The chart that sums up the page: bytes and times of everything that was measured.
std::string chart_of_size_and_speed(const ComparisonFigures& figures);

// The other charts, a sequence of <figure> elements.
std::string comparison_charts(const ComparisonFigures& figures);

}  // namespace psplit
