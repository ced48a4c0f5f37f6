// What `compare A B` prints.
#pragma once

#include <string>

#include "gltf_ext/compare/asset_comparison.h"
#include "gltf_ext/json/json.h"

namespace psplit {

// `first` and `second` are the names of the two assets.
std::string to_text(const AssetComparison& comparison, const std::string& first, const std::string& second);
Json to_json(const AssetComparison& comparison);

}  // namespace psplit
