// Memory to load primitives into.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "psplit/loader.h"

namespace psplit {

// Buffers for `points` and `faces`, with `gap` bytes between values, which decoding must not touch.
struct Buffers {
  std::vector<std::byte> indices;
  std::vector<std::vector<std::byte>> values;
  std::vector<size_t> sizes, strides;
  PrimitiveBuffers out;
  static constexpr std::byte kUntouched{0xA5};

  Buffers(std::span<const AttributeRequest> requests, uint32_t points, uint32_t faces, uint32_t index_bytes = 4,
          size_t gap = 0)
      : indices(size_t{3} * faces * index_bytes) {
    out = {indices, index_bytes};
    for (const AttributeRequest& request : requests) {
      sizes.push_back(component_bytes(request.component_type) * request.component_count);
      strides.push_back(sizes.back() + gap);
      values.emplace_back(points * strides.back(), kUntouched);
      out.attributes.push_back({values.back(), strides.back()});
    }
  }
  Buffers(const Buffers&) = delete;

  // The mesh without gaps. Checks that the gaps are untouched.
  Mesh mesh(std::span<const AttributeRequest> requests, uint32_t points) const {
    Mesh mesh;
    mesh.point_count = points;
    mesh.faces.resize(indices.size() / out.index_bytes / 3);
    std::fill(mesh.faces.begin(), mesh.faces.end(), std::array<uint32_t, 3>{});
    for (size_t i = 0; i < 3 * mesh.faces.size(); ++i)
      std::memcpy(&mesh.faces[i / 3][i % 3], &indices[i * out.index_bytes], out.index_bytes);
    for (size_t k = 0; k < requests.size(); ++k) {
      const AttributeRequest& request = requests[k];
      Attribute attribute{
          request.semantic, request.component_type, request.component_count, request.normalized, {}};
      for (uint32_t point = 0; point < points; ++point)
        for (size_t byte = 0; byte < strides[k]; ++byte) {
          const std::byte value = values[k][point * strides[k] + byte];
          if (byte < sizes[k])
            attribute.values.push_back(value);
          else
            EXPECT_EQ(value, kUntouched);
        }
      mesh.attributes.push_back(std::move(attribute));
    }
    return mesh;
  }
};

}  // namespace psplit
