// What differs between two assets, for people and for programs.
#pragma once

#include <string>

#include "gltf_ext/json/json.h"
#include "tools/gltf_psplit/diff/compare_assets.h"

namespace psplit {

// `first` and `second` are the names of the two assets.
std::string to_text(const AssetComparison& comparison, const std::string& first, const std::string& second);
Json to_json(const AssetComparison& comparison);

}  // namespace psplit
