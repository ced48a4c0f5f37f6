// An asset that may be larger than memory, for comparisons: its meshes are in mapped or temporary files.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gltf_ext/compare/declared_grids.h"
#include "gltf_ext/document/document.h"
#include "gltf_ext/files/mapped_file.h"
#include "gltf_ext/primitive/memory_limit.h"
#include "gltf_ext/primitive/mesh_view.h"
#include "tools/gltf_psplit/options/backend_choice.h"
#include "tools/gltf_psplit/options/session.h"

namespace psplit {

struct LargePrimitive {
  size_t mesh = 0;        // its number
  int64_t material = -1;  // its number, or -1
  MeshView view;
  std::map<std::string, DeclaredGrid> grids;
  // What the view points to, except for the document.
  FileMemory memory;
  std::unique_ptr<Mesh> in_memory;
};

struct LargeAsset {
  Document document;
  std::vector<LargePrimitive> primitives;  // in the order of the meshes
  size_t mesh_count = 0, material_count = 0;
};

// Bytes of the meshes of an asset, in memory: for the choice between a comparison in memory and by sums. 0 if
// the file cannot be read (reading it then reports the error), or if it surely fits into the limit.
uint64_t estimate_mesh_bytes(const std::string& path, const MemoryLimit& limit);

// Patches, mesh files (PLY, STL) and the content of pipes are put into temporary files, plain accessors stay
// where they are. Errors: kUnsupported for what only a comparison in memory compares: lines, points, morph
// targets, positions that are not floats; those of reading.
Expected<LargeAsset> read_large_asset(const std::string& path, const BackendChoice& backend,
                                      const MemoryLimit& limit, const Session& session);

}  // namespace psplit
