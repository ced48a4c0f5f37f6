// Integers in a container's bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace psplit {

// `width` is at most 4.
inline uint32_t load_integer(const uint8_t* at, size_t width) {
  uint32_t value = 0;
  for (size_t i = 0; i < width; ++i) value |= static_cast<uint32_t>(at[i]) << (8 * i);
  return value;
}
inline void append_integer(std::vector<uint8_t>& bytes, uint32_t value, size_t width) {
  for (size_t i = 0; i < width; ++i) bytes.push_back(static_cast<uint8_t>(value >> (8 * i)));
}

}  // namespace psplit
