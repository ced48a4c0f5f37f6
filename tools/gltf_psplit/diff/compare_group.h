// Compares the elements of some primitives of one asset with the elements of some primitives of another: a step
// of compare_assets.h.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tools/gltf_psplit/diff/compare_assets.h"
#include "tools/gltf_psplit/diff/read_asset_meshes.h"

namespace psplit {

// The compared attributes of a primitive: semantics and numbers of components, POSITION first, then by name.
std::vector<std::pair<std::string, int>> compared_attributes(const AssetPrimitive& primitive,
                                                             const CompareRules& rules);

// The primitives of each side must have the same attributes and the same kind of elements. The two sides may
// differ, and one of them may be empty. Fills in alone, degenerate_alone, values and first.
Expected<AssetComparison> compare_group(std::span<const AssetPrimitive* const> a,
                                        std::span<const AssetPrimitive* const> b, bool with_materials,
                                        const CompareRules& rules, const CompareMeans& means);

}  // namespace psplit
