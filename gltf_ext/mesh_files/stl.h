// STL, in text and in binary.
#pragma once

#include "gltf_ext/mesh_files/mesh_file.h"
#include "gltf_ext/mesh_files/scanner.h"

namespace psplit {

// Whether the file is STL in text. The word "solid" does not tell: many programs begin the header of a binary
// file with it. A file is binary where its size is what its count of facets makes it, and text where "solid" is
// followed by nothing but text.
bool is_text_stl(Scanner& scanner);
// Whether the size is what the count of facets makes it; false where the size is unknown.
bool has_size_of_binary_stl(Scanner& scanner);

// One object a solid, with the facets' normals. Points of equal position and normal are one point. Errors:
// kInvalidInput with the line or byte: facets that are not there, words that are no numbers, positions that are
// not finite.
Expected<MeshFile> read_stl(Scanner& scanner);

}  // namespace psplit
