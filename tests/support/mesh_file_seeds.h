// Small mesh files of every format, which tests and fuzzers change.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

namespace psplit {

std::vector<std::string> mesh_file_seeds();

// A normal and three corners.
using StlFacet = std::array<float, 12>;
std::string binary_stl(std::span<const StlFacet> facets);

}  // namespace psplit
