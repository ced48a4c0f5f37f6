// Streams of bitstreams before 2.2, which a library of the caller's decodes.
#pragma once

#include <span>

#include "psplit/decode.h"

namespace psplit {

// Describes a stream that was refused, if it is a mesh of a bitstream before 2.2 and `older` is not null.
// Errors: otherwise `refusal`, with a sentence that says what decodes older meshes; errors of `older`.
Expected<StreamDescription> describe_older(const OlderStreams* older, std::span<const uint8_t> stream,
                                           const Status& refusal);

// Decodes the stream into buffers for point_count points and face_count faces. kInvalidInput if it has other
// numbers.
Status decode_older(const OlderStreams& older, std::span<const uint8_t> stream,
                    std::span<const AttributeRequest> requests, uint32_t point_count, uint32_t face_count,
                    const PrimitiveBuffers& out);

}  // namespace psplit
