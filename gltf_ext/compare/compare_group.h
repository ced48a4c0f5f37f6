// The elements of some primitives of one asset against those of some primitives of another: a step of
// compare_assets.h.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "gltf_ext/compare/asset_comparison.h"
#include "gltf_ext/compare/read_asset_meshes.h"

namespace psplit {

// What of a primitive is compared: semantics and numbers of components, POSITION first, then by name.
std::vector<std::pair<std::string, int>> compared_attributes(const AssetPrimitive& primitive,
                                                             const CompareRules& rules);

// Primitives of one side have the same attributes and the same kind of elements; those of the other may differ,
// and one of the sides may be empty. Fills in alone, degenerate_alone, values and first.
Expected<AssetComparison> compare_group(std::span<const AssetPrimitive* const> a,
                                        std::span<const AssetPrimitive* const> b, bool with_materials,
                                        const CompareRules& rules);

}  // namespace psplit
