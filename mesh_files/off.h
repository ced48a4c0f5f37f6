// OFF, the format of Geomview, in text.
#pragma once

#include "mesh_files/mesh_file.h"
#include "mesh_files/scanner.h"

namespace psplit {

// Whether a word is the keyword at the start of an OFF file: OFF, with ST, C and N before it for texture
// coordinates, colours and normals.
bool is_off_keyword(std::string_view word);

// Reads vertices with the attributes that the keyword states, and polygons. Colours of polygons are left out
// and count as losses. The keyword may be missing. Colours are floats from 0 to 1, or, if all are whole
// numbers, from 0 to 255. Errors: kInvalidInput with the line; kUnsupported for binary files, dimensions other
// than three, and point clouds.
Expected<MeshFile> read_off(Scanner& scanner);

}  // namespace psplit
