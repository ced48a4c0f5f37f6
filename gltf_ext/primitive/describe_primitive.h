// What the streams of a compressed primitive state.
#pragma once

#include <vector>

#include "gltf_ext/primitive/read_primitives.h"
#include "psplit/decode.h"

namespace psplit {

struct DescribedPrimitive {
  std::vector<AttributeRequest> requests;
  std::vector<StreamDescription> streams;  // of stock Draco one, of a container one for each patch
};

// `describe` is for stock Draco; patches are described by describe_patch (psplit/decode.h). Errors:
// as for both, and kInvalidInput.
Expected<DescribedPrimitive> describe_primitive(const Document& document, PrimitiveId id,
                                                const DescribeStream& describe, const ThreadPool& pool);

}  // namespace psplit
