// The quantization grids that a file declares: how far its values may be from the original values.
#pragma once

#include <map>
#include <string>

#include "encoder/coding/attribute_coding.h"
#include "gltf_ext/primitive/read_primitives.h"
#include "src/container/stream_description.h"

namespace psplit {

struct DeclaredGrid {
  double within = 0;  // the largest error of a component; for directions, of the chord between unit vectors
  std::string identity{};    // equal for equal grids; empty if the streams have several grids
  AttributeCoding coding{};  // the grid, or one of them
};

// The grids of the quantized attributes of a compressed primitive, by semantic, as its streams state them.
// Empty for a plain primitive. Errors: those of `describe`, kInvalidInput.
Expected<std::map<std::string, DeclaredGrid>> declared_grids(const Document& document, PrimitiveId id,
                                                             const DescribeStream& describe,
                                                             const ThreadPool& pool);

}  // namespace psplit
