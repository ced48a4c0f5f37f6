// PLY, OBJ and STL files through libdraco's readers.
#pragma once

#include <filesystem>

#include "src/mesh/mesh.h"
#include "src/status.h"

namespace psplit {

// True for .ply, .obj and .stl, in any case.
bool is_mesh_file(const std::filesystem::path& path);

// Attributes as gltf_attributes (src/container/stream_description.h) names them. Polygons become triangles.
// Errors: kIo, kInvalidInput (not a mesh of that format, no positions), kUnsupported (no faces: a point cloud).
Expected<Mesh> read_mesh_file(const std::filesystem::path& path);

}  // namespace psplit
