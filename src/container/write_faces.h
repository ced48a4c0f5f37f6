// Faces in the caller's memory, whose indices have 2 or 4 bytes.
#pragma once

#include <cstdint>

namespace psplit {

// Calls write(indices), with a pointer to integers of that size.
template <typename Write>
void with_indices(void* indices, uint32_t index_bytes, Write write) {
  if (index_bytes == 2)
    write(static_cast<uint16_t*>(indices));
  else
    write(static_cast<uint32_t*>(indices));
}

// Writes three indices for each face; point_of(face, k) is the k-th.
template <typename PointOf>
void write_faces(uint32_t face_count, void* indices, uint32_t index_bytes, PointOf point_of) {
  with_indices(indices, index_bytes, [&]<typename Out>(Out* out) {
    for (uint32_t face = 0; face < face_count; ++face)
      for (uint32_t k = 0; k < 3; ++k) *out++ = static_cast<Out>(point_of(face, k));
  });
}

}  // namespace psplit
