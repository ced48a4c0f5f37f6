// What a file says of how far its values are from those that they were made of.
#pragma once

#include <map>
#include <string>

#include "gltf_ext/primitive/read_primitives.h"
#include "src/container/stream_description.h"

namespace psplit {

struct DeclaredGrid {
  double within = 0;       // of a component; of directions, the chord between unit vectors
  bool direction = false;  // on an octahedron
  std::string identity;    // the same for the same grid; empty where the streams have several
};

// Those of a compressed primitive's quantized attributes, by semantic: its streams know them. None of a plain
// primitive. Errors: those of `describe`, kInvalidInput.
Expected<std::map<std::string, DeclaredGrid>> declared_grids(const Document& document, PrimitiveId id,
                                                             const DescribeStream& describe,
                                                             const ThreadPool& pool);

}  // namespace psplit
