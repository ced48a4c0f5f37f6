// How the elements of an accessor are laid out in its buffer view.
#pragma once

#include "gltf_ext/json/json.h"
#include "src/mesh/mesh.h"
#include "src/status.h"

namespace psplit {

// One element. Columns of a matrix start on 4-byte boundaries.
struct ElementLayout {
  ComponentType component_type = ComponentType::kFloat32;
  uint8_t rows = 1;
  uint8_t columns = 1;

  uint8_t component_count() const { return static_cast<uint8_t>(rows * columns); }
  size_t column_bytes() const { return rows * component_bytes(component_type); }
  size_t column_stride() const { return columns == 1 ? column_bytes() : (column_bytes() + 3) / 4 * 4; }
  size_t packed_bytes() const { return column_bytes() * columns; }   // without padding
  size_t stored_bytes() const { return column_stride() * columns; }  // the stride if none is stated
  // The bytes of the last element: nothing pads its last column.
  size_t last_bytes() const { return column_stride() * (columns - 1u) + column_bytes(); }
};

// Errors: kInvalidInput if componentType or type is invalid.
Expected<ElementLayout> element_layout(const Json& accessor);

// Whether `count` elements that begin at `offset`, `stride` bytes apart, fit into `available` bytes.
bool elements_fit(const ElementLayout& layout, uint64_t offset, uint64_t stride, uint64_t count,
                  uint64_t available);

}  // namespace psplit
