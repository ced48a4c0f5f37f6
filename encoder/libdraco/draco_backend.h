// Single streams by stock libdraco. psplit/encode.h has the backend. Without libdraco (PSPLIT_WITH_DRACO=OFF)
// both functions return kUnsupported.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "psplit/base.h"
#include "psplit/decode.h"

namespace psplit {

// One Draco mesh stream as libdraco decodes it, with faces and points in its order.
Expected<Mesh> decode_draco_stream(Span<const uint8_t> stream, Span<const AttributeRequest> requests);

// Describes a mesh stream of any version that libdraco decodes. Streams before 1.3 have no unique ids: their
// attributes get their places as ids, here and in the backend. Errors: kInvalidInput.
Expected<StreamDescription> describe_draco_stream(Span<const uint8_t> stream);

}  // namespace psplit
