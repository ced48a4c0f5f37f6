// Stock libdraco as a decode backend: the oracle of every other one.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "src/container/decode_backend.h"

namespace psplit {

DecodeBackend draco_backend();

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

// Quantization bits of each request's attribute in a stream; 0 where it is stored as it is.
Expected<std::vector<int>> stream_attribute_bits(std::span<const uint8_t> stream,
                                                 std::span<const AttributeRequest> requests);

}  // namespace psplit
