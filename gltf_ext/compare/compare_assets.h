// Whether two assets hold the same meshes up to order and quantization, and where they first differ.
//
// Two meshes are the same if each triangle of one has a partner in the other with the same values at its
// corners and the same orientation. Points may be split or merged as long as their values stay. Elements may
// come in any order and begin at any corner. Two values may differ by as much as the files' own quantization
// grids allow: the grids of Draco streams, and of integers if the other file stores another type. Otherwise
// values must be equal to the bit, except for the sign of zero. Lines and points are compared in the same way.
// Morph targets are compared as attributes of the points that they move.
//
// Not compared: nodes and their transforms; materials, except for their number, if both assets have equally
// many; names; points that no element uses; and degenerate triangles, which encoders drop. The last two are
// counted.
#pragma once

#include "gltf_ext/compare/asset_comparison.h"
#include "gltf_ext/compare/read_asset_meshes.h"

namespace psplit {

// Errors: kRuntimeFailure (match_elements.h), kUnsupported (2^32 elements and more in one mesh).
Expected<AssetComparison> compare_assets(const AssetMeshes& a, const AssetMeshes& b, const CompareRules& rules);

}  // namespace psplit
