// Wavefront OBJ: polygons with texture coordinates, normals, objects and materials.
#pragma once

#include <functional>

#include "gltf_ext/mesh_files/mesh_file.h"
#include "gltf_ext/mesh_files/mtl.h"
#include "gltf_ext/mesh_files/scanner.h"

namespace psplit {

// Opens what a mtllib line names, relative to the OBJ file.
using OpenLibrary = std::function<Expected<std::unique_ptr<ByteStream>>(const std::string& path)>;

// One object an "o"; in it one part for each material, and for each set of attributes that faces have: those
// with normals and those without do not fit in one. Corners of equal position, texture coordinates and normal
// are one point, in the order of the faces; vertices that no face uses are not there. Six numbers of a "v" are
// a position and a colour. OBJ counts v from the bottom of the image, glTF from the top. A library that does
// not open is a loss; so are lines, points, curves and surfaces. Errors: kInvalidInput with the line (no
// number, a position that is not finite, a vertex that is not there), kUnsupported (many more objects or
// materials than the file's bytes justify).
Expected<MeshFile> read_obj(Scanner& scanner, const OpenLibrary& open_library);

}  // namespace psplit
