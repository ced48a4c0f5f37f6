// Small mesh files of every format, which tests and fuzzers change.
#pragma once

#include <string>
#include <vector>

namespace psplit {

std::vector<std::string> mesh_file_seeds();

}  // namespace psplit
