// The meshes of an asset, decoded, as compare_assets takes them.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "gltf_ext/compare/declared_grids.h"

namespace psplit {

struct AssetPrimitive {
  PrimitiveId id;
  size_t whole = 0;  // index of what it is part of: a mesh, or a scene
  int64_t material = -1;
  int corner_count = 3;  // of each element: 3 for triangles, 2 for lines, 1 for points
  Mesh mesh;             // `faces` are the elements; morph targets are attributes: "target 0 POSITION"
  std::map<std::string, DeclaredGrid> grids;
  // The values are in a buffer without bytes (document.h): there is nothing to compare, and `mesh` is empty.
  bool has_no_data = false;
};

struct AssetMeshes {
  std::vector<AssetPrimitive> primitives;  // in the order of the meshes
  size_t whole_count = 0;                  // every `whole` is below it
  size_t material_count = 0;
};

// Errors: the cause why a primitive cannot be read, with its place.
Expected<AssetMeshes> read_asset_meshes(const Document& document, const DecodeBackend& backend,
                                        const DescribeStream& describe, const ThreadPool& pool,
                                        const Progress& progress = {});

}  // namespace psplit
