// A mesh in temporary files, laid out as a buffer of glTF.
#pragma once

#include <filesystem>

#include "gltf_ext/out_of_core/mesh_spool.h"
#include "gltf_ext/primitive/mesh_view.h"

namespace psplit {

// The points and faces of the finished spool in one temporary file in `folder`. Facets get three points each.
// Errors: those of the files; kUnsupported if there are more indices than an accessor can count.
Expected<MeshInFile> lay_out_spool(const MeshSpool& spool, const std::filesystem::path& folder);

}  // namespace psplit
