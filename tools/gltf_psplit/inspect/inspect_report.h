// What `inspect` prints: one asset in detail, or one line for each of several assets.
#pragma once

#include <span>
#include <string>

#include "tools/gltf_psplit/inspect/inspected_asset.h"

namespace psplit {

Json to_json(const InspectedAsset& asset);

// A table of the compressed primitives, then a line for each plain one. `wide`: all columns.
std::string to_text(const InspectedAsset& asset, bool wide);
// One line for each asset.
std::string to_text(std::span<const InspectedAsset> assets, bool wide);

// "dragon.glb: 1.18 MB, mesh data 1.15 MB in 1 primitive and 45 patches"
std::string summary_text(const InspectedAsset& asset);

}  // namespace psplit
