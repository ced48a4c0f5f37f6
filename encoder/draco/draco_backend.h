// Stock libdraco as a decode backend: the oracle of every other one.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "src/container/decode_backend.h"
#include "src/container/stream_description.h"

namespace psplit {

DecodeBackend draco_backend();

// Of the libdraco that this was built with.
std::string draco_version();

// One Draco mesh stream as libdraco decodes it: faces and points in its order.
struct DecodedStream {
  uint32_t point_count = 0;
  Array<std::array<uint32_t, 3>> faces;
  std::vector<Array<std::byte>> values;  // one per request, point_count * stride bytes
};
Expected<DecodedStream> decode_draco_stream(std::span<const uint8_t> stream,
                                            std::span<const AttributeRequest> requests);

struct StreamCounts {
  uint32_t face_count = 0;
  uint32_t point_count = 0;
};
Expected<StreamCounts> stream_counts(std::span<const uint8_t> stream);

// What a mesh stream of any version that libdraco decodes is. Attributes of streams before 1.3, which have no
// unique ids, have their places for ids, here and for the backend. Errors: kInvalidInput.
Expected<StreamDescription> describe_draco_stream(std::span<const uint8_t> stream);

}  // namespace psplit
