// OFF, Geomview's and everyone's, in text.
#pragma once

#include "gltf_ext/mesh_files/mesh_file.h"
#include "gltf_ext/mesh_files/scanner.h"

namespace psplit {

// Whether a word is the keyword that OFF files begin with: OFF, and with ST, C and N before it for texture
// coordinates, colours and normals.
bool is_off_keyword(std::string_view word);

// Vertices with what the keyword says, and polygons; colours of polygons are left out, which the losses say.
// The keyword may be missing. Colours are floats from 0 to 1, or whole numbers from 0 to 255 where all are.
// Errors: kInvalidInput with the line, kUnsupported for binary files, other dimensions than three, and point
// clouds.
Expected<MeshFile> read_off(Scanner& scanner);

}  // namespace psplit
