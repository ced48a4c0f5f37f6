// Normals that are not unit vectors. glTF forbids them; they pass through unchanged.
#pragma once

#include "gltf_ext/document/document.h"

namespace psplit {

// The number of such vectors in the float NORMAL accessors of plain primitives.
uint64_t count_odd_normals(const Document& document);

}  // namespace psplit
