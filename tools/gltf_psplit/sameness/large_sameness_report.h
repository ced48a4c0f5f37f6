// The result of compare_large, for people and for programs.
#pragma once

#include <string>

#include "gltf_ext/json/json.h"
#include "tools/gltf_psplit/sameness/large_sameness.h"

namespace psplit {

// `first` and `second` are the names of the two assets.
std::string to_text(const LargeComparison& comparison, const std::string& first, const std::string& second);
Json to_json(const LargeComparison& comparison);

}  // namespace psplit
