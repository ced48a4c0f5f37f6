// Stock libdraco as a decode backend. All other decoders are compared with it. Without libdraco
// (PSPLIT_WITH_DRACO=OFF) all that decodes returns kUnsupported.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "src/container/decode_backend.h"
#include "src/container/stream_description.h"
#include "src/export.h"
#include "src/span.h"

namespace psplit {

// Decodes each stream with libdraco to a mesh of libdraco's, one thread for each patch. Stock streams may be of
// any bitstream that libdraco knows. Errors: kInvalidInput. Checks before each task whether to stop, and
// reports progress in tasks. Thread-safe.
PSPLIT_EXPORT DecodeBackend draco_backend();

// The version of the libdraco that this was built with; empty if there is none.
PSPLIT_EXPORT std::string draco_version();
inline bool has_draco() { return !draco_version().empty(); }

// One Draco mesh stream as libdraco decodes it, with faces and points in its order.
Expected<Mesh> decode_draco_stream(Span<const uint8_t> stream, Span<const AttributeRequest> requests);

// Describes a mesh stream of any version that libdraco decodes. Streams before 1.3 have no unique ids: their
// attributes get their places as ids, here and in the backend. Errors: kInvalidInput.
Expected<StreamDescription> describe_draco_stream(Span<const uint8_t> stream);

}  // namespace psplit
