// A primitive of a document, by the index of its mesh and its index in that mesh.
#pragma once

#include <vector>

#include "gltf_ext/document/document.h"

namespace psplit {

struct PrimitiveId {
  size_t mesh = 0;
  size_t primitive = 0;
};

// All primitives, mesh by mesh. Skips members that are not arrays.
std::vector<PrimitiveId> all_primitives(const Document& document);

}  // namespace psplit
