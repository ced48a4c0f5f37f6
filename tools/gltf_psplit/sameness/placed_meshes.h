// The meshes of an asset at the places where its scene puts them. This compares assets of tools that move a
// part of the positions into nodes, as quantizing tools do.
#pragma once

#include "gltf_ext/compare/read_asset_meshes.h"

namespace psplit {

// Each mesh appears once for each node of the default scene that uses it, and all together form one whole.
// Positions, normals and tangents are transformed by the node and its parents. Morph targets are left out;
// skins, animations and EXT_mesh_gpu_instancing are ignored. Quantization grids are scaled with the values and
// widened by float rounding. Errors: those of scene_instances; kUnsupported if the scene repeats its meshes too
// often.
Expected<AssetMeshes> place_meshes(const Document& document, const AssetMeshes& asset);

}  // namespace psplit
