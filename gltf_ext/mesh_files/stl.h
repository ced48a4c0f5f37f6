// STL, in text and binary.
#pragma once

#include "gltf_ext/mesh_files/mesh_file.h"
#include "gltf_ext/mesh_files/scanner.h"

namespace psplit {

// Whether the file is STL in text. The word "solid" is not enough, because many programs begin the header of a
// binary file with it. A file is binary if its size matches its count of facets, and text if only text follows
// "solid".
bool is_text_stl(Scanner& scanner);
// Whether the size of the file matches its count of facets. False if the size is unknown.
bool has_size_of_binary_stl(Scanner& scanner);

// One object for each solid, with the normals of the facets. Points with equal position and normal are one
// point. Errors: kInvalidInput with the line or byte (missing facets, words that are not numbers, positions
// that are not finite).
Expected<MeshFile> read_stl(Scanner& scanner);

}  // namespace psplit
