// Normals that glTF does not allow, and that pass through as they are.
#pragma once

#include "gltf_ext/document/document.h"

namespace psplit {

// How many vectors of the accessors that plain primitives have as NORMAL, floats, are not of unit length.
uint64_t count_odd_normals(const Document& document);

}  // namespace psplit
