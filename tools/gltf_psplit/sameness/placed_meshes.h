// The meshes of an asset where its scene puts them: for tools that move what a mesh holds to its node, as
// quantizing ones do.

#include "gltf_ext/compare/read_asset_meshes.h"
#pragma once

namespace psplit {

// Every mesh once for each node of the default scene that has it, positions, normals and tangents as the node
// and its parents transform them, all of them parts of one whole. Without morph targets; skins, animations and
// EXT_mesh_gpu_instancing change nothing. Grids get as much wider as the values, and by float rounding. Errors:
// those of scene_instances; kUnsupported for scenes that repeat their meshes too often.
Expected<AssetMeshes> place_meshes(const Document& document, const AssetMeshes& asset);

}  // namespace psplit
