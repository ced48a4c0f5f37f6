// What the streams of a compressed primitive state.
#pragma once

#include <vector>

#include "gltf_ext/primitive/read_primitives.h"
#include "src/container/stream_description.h"

namespace psplit {

struct DescribedPrimitive {
  std::vector<AttributeRequest> requests;
  std::vector<StreamDescription> streams;  // of stock Draco one, of a container one for each patch
};

// `describe` is for stock Draco; patches are described by describe_patch (src/cpu/draco_stream.h). Errors:
// those of both, and kInvalidInput.
Expected<DescribedPrimitive> describe_primitive(const Document& document, PrimitiveId id,
                                                const DescribeStream& describe, const ThreadPool& pool);

}  // namespace psplit
