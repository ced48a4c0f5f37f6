// Which primitives of two large assets are compared with each other, by the rules of compare_assets.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "tools/gltf_psplit/sameness/large_asset.h"

namespace psplit {

using LargeGroup = std::vector<const LargePrimitive*>;

// The attributes that count, with their numbers of components: POSITION first, then in order of names. If
// `only` is not empty, others than these and POSITION do not count.
std::vector<std::pair<std::string, int>> compared_attributes(const LargePrimitive& primitive,
                                                             const std::vector<std::string>& only);

// The primitives of both sides with the same attributes and, if `by_material`, with the same material.
std::vector<std::array<LargeGroup, 2>> groups_of(const LargeGroup& a, const LargeGroup& b, bool by_material,
                                                 const std::vector<std::string>& only);

// How the primitives differ before any of their values is read: a part of a sentence. Empty if they do not
// differ, or if there are no triangles. Each group has the attributes of its first primitive.
std::string difference_of_kind(const LargeGroup& a, const LargeGroup& b, bool by_material,
                               const std::vector<std::string>& only);

}  // namespace psplit
