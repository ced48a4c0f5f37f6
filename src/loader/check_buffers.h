// Checks that the caller's memory has room for a mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "psplit/decode.h"

namespace psplit {

inline constexpr uint32_t kMost16BitPoints = 0xffff;  // glTF keeps the largest index for restarts
// Bytes of an index: 2 if all point numbers fit, otherwise 4.
constexpr uint32_t least_index_bytes(uint32_t point_count) { return point_count <= kMost16BitPoints ? 2 : 4; }

// Bytes of an attribute's value.
struct NamedSize {
  std::string name;
  size_t bytes = 0;
};

// The buffers with their strides filled in. Errors: kUsage if they have no room for the counts.
Expected<PrimitiveBuffers> check_buffers(std::span<const NamedSize> attributes, const PrimitiveBuffers& out,
                                         uint32_t point_count, uint32_t face_count);

}  // namespace psplit
