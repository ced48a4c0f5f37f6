// The assets of a comparison, which may be larger than memory.
#pragma once

#include <string>

#include "gltf_ext/document/document.h"
#include "mesh_files/origin.h"
#include "psplit/document.h"
#include "tools/gltf_psplit/diff/read_asset_meshes.h"
#include "tools/gltf_psplit/options/backend_choice.h"
#include "tools/gltf_psplit/options/session.h"

namespace psplit {

struct ComparedAsset {
  Document document;
  AssetMeshes meshes;
  bool is_mesh_file = false;
  std::vector<std::string> warnings{};     // of reading
  std::vector<PrecisePosition> origins{};  // mesh_origins
};

// Bytes of the meshes of an asset, in memory. 0 if the file cannot be read (reading it then reports the error),
// or if it surely fits into the limit.
uint64_t estimate_mesh_bytes(const std::string& path, const MemoryLimit& limit);

// Reads an asset into memory. With `limit`, patches, mesh files (PLY, STL) and the content of pipes are put
// into temporary files, and plain accessors stay where they are; only what has no such form is in memory: other
// streams, lines, points, morph targets. `origin` is for mesh files. Errors: as for reading.
Expected<ComparedAsset> read_compared(const std::string& path, const BackendChoice& backend,
                                      const MemoryLimit* limit, const Session& session,
                                      const OriginChoice& origin);

// For each mesh, where the scene puts it, if all nodes that use it move it to the same place and do nothing
// else to it; otherwise zeros.
std::vector<PrecisePosition> mesh_origins(const Document& document);
// Half a step of a grid of positions: less than DeclaredGrid::within, which has what floats lose there, too.
double half_step(const DeclaredGrid& positions);
// How to read a mesh file that is compared with this asset: relative to its origins. If it has none, or if
// floats are coarse there, floats may lose what its grid allows, or what encoding allows by default.
OriginChoice origin_beside(const ComparedAsset& other);

// Where the scene has its positions.
Expected<PositionSpread> spread_of_scene(const Document& document, const AssetMeshes& asset);

// The meshes at the places where the scene puts them, to compare assets of tools that move a part of the
// positions into nodes, as quantizing tools do. Each mesh appears once for each node of the default scene that
// uses it, and all together form one whole. Positions, normals and tangents are transformed by the node and its
// parents. Morph targets are left out; skins, animations and EXT_mesh_gpu_instancing are ignored. Quantization
// grids are scaled with the values and widened by float rounding. Positions are floats relative to `origin`.
// Errors: as for scene_instances; kUnsupported if the scene repeats its meshes too often.
Expected<AssetMeshes> place_meshes(const Document& document, const AssetMeshes& asset,
                                   const PrecisePosition& origin);

}  // namespace psplit
