// A mesh in arrays that belong to someone else.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "src/mesh/mesh.h"
#include "src/span.h"

namespace psplit {

// Values, or indices. Bytes may have any alignment.
struct ValuesView {
  ComponentType component_type = ComponentType::kFloat32;
  uint8_t component_count = 1;
  bool normalized = false;
  uint32_t count = 0;
  Span<const std::byte> bytes{};
  size_t stride = 0;  // from one value to the next; 0: tightly packed

  size_t value_bytes() const { return component_bytes(component_type) * component_count; }
  size_t step() const { return stride == 0 ? value_bytes() : stride; }
  const std::byte* at(size_t index) const { return bytes.data() + index * step(); }
};

struct MeshView {
  struct Values {
    std::string semantic;
    ValuesView values;
  };
  uint32_t point_count = 0;
  std::vector<Values> attributes{};
  ValuesView indices{};  // unsigned, three for each face; without bytes they are 0, 1, 2 and so on

  // Null if the mesh has no such attribute.
  const ValuesView* find(const std::string& semantic) const {
    for (const Values& attribute : attributes)
      if (attribute.semantic == semantic) return &attribute.values;
    return nullptr;
  }
  uint32_t index(size_t number) const {
    if (indices.bytes.empty()) return static_cast<uint32_t>(number);
    uint32_t index = 0;
    std::memcpy(&index, indices.at(number), indices.value_bytes());  // little-endian, as glTF
    return index;
  }
};

}  // namespace psplit
