// PLY, OBJ, STL and DRC files through libdraco's readers.
#pragma once

#include <filesystem>

#include "src/mesh/mesh.h"
#include "src/status.h"

namespace psplit {

// True for .ply, .obj, .stl and .drc, in any case.
bool is_mesh_file(const std::filesystem::path& path);

// Positions, normals, texture coordinates, colours and generic attributes as glTF semantics. Polygons become
// triangles. Errors: kIo, kInvalidInput (not a mesh of that format), kUnsupported (no faces: a point cloud).
Expected<Mesh> read_mesh_file(const std::filesystem::path& path);

}  // namespace psplit
