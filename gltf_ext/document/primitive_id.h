// The primitives of a document, each by its mesh and its place in that mesh.
#pragma once

#include <vector>

#include "gltf_ext/document/document.h"

namespace psplit {

struct PrimitiveId {
  size_t mesh = 0;
  size_t primitive = 0;
};

// All primitives, mesh by mesh. Skips what is not an array.
std::vector<PrimitiveId> all_primitives(const Document& document);

}  // namespace psplit
