// A Draco stream of a bitstream that no encoder of today writes.
#pragma once

#include <cstdint>
#include <vector>

namespace psplit {

// A sequential mesh of bitstream 2.1 with two triangles (0, 1, 2) and (2, 1, 3), whose values are stored as
// they are: positions with the unique id 5, and 9, 8, 7, 6 of kUint16, generic, with the id 7.
inline std::vector<uint8_t> older_stream() {
  std::vector<uint8_t> stream = {'D', 'R', 'A', 'C', 'O', 2, 1, 1, 0, 0, 0, 2, 0, 0, 0, 4, 0, 0, 0, 1,
                                 // indices, the number of decoders, their attributes, how these are stored
                                 0, 1, 2, 2, 1, 3, 1, 2, 0, 9, 3, 0, 5, 4, 4, 1, 0, 7, 0, 0};
  const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.5F};
  const uint16_t ids[] = {9, 8, 7, 6};
  const auto append = [&](const void* data, size_t size) {
    const auto* const bytes = static_cast<const uint8_t*>(data);
    stream.insert(stream.end(), bytes, bytes + size);
  };
  append(positions, sizeof(positions));
  append(ids, sizeof(ids));
  return stream;
}

}  // namespace psplit
