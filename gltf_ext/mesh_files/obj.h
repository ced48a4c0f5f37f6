// Wavefront OBJ: polygons with texture coordinates, normals, objects and materials.
#pragma once

#include <functional>

#include "gltf_ext/mesh_files/mesh_file.h"
#include "gltf_ext/mesh_files/mtl.h"
#include "gltf_ext/mesh_files/scanner.h"

namespace psplit {

// Opens the file that a mtllib line names, relative to the OBJ file.
using OpenLibrary = std::function<Expected<std::unique_ptr<ByteStream>>(const std::string& path)>;

// One object for each "o" statement. An object has one part for each material and each set of attributes,
// because faces with normals and faces without normals cannot share a primitive. Corners with equal position,
// texture coordinates and normal are one point; points are in the order of the faces. Vertices that no face
// uses are left out. Six numbers of a "v" are a position and a colour. OBJ counts v from the bottom of the
// image, glTF from the top. A library that cannot be opened is a loss, and so are lines, points, curves and
// surfaces. Errors: kInvalidInput with the line (a word that is not a number, a position that is not finite, a
// vertex that does not exist), kUnsupported (many more objects or materials than the file's bytes justify).
Expected<MeshFile> read_obj(Scanner& scanner, const OpenLibrary& open_library);

}  // namespace psplit
