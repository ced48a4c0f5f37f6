// What must hold of a glTF tree before its indices may be followed.
#pragma once

#include "gltf_ext/document/document.h"
#include "src/mesh/mesh.h"

namespace psplit {

// How one element of an accessor lies in its buffer view. Columns of a matrix start on 4-byte boundaries.
struct ElementLayout {
  ComponentType component_type = ComponentType::kFloat32;
  uint8_t rows = 1;
  uint8_t columns = 1;

  uint8_t component_count() const { return static_cast<uint8_t>(rows * columns); }
  size_t column_bytes() const { return rows * component_bytes(component_type); }
  size_t column_stride() const { return columns == 1 ? column_bytes() : (column_bytes() + 3) / 4 * 4; }
  size_t packed_bytes() const { return column_bytes() * columns; }   // without padding
  size_t stored_bytes() const { return column_stride() * columns; }  // the stride where none is stated
  size_t last_bytes() const {
    return column_stride() * (columns - 1u) + column_bytes();
  }  // of the last element
};

Expected<ElementLayout> element_layout(const Json& accessor);

// Whether `count` elements of `layout`, `stride` bytes apart from `offset` on, lie in `available` bytes.
bool elements_fit(const ElementLayout& layout, uint64_t offset, uint64_t stride, uint64_t count,
                  uint64_t available);

// Version, kinds of the top-level members, required members, types of attributes, every index of an accessor,
// buffer view or buffer, and every extent, against what the JSON says; and check_scene. What is unknown is
// allowed.
Status check_structure(const Json& json);

// The names under which views compressed by meshoptimizer are known.
inline constexpr const char* kMeshoptExtensions[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

// The meshopt extension of a buffer or a buffer view, or null.
const Json* meshopt_extension(const Json& object);
Json* meshopt_extension(Json& object);
// Takes it off an object that has it.
void erase_meshopt_extension(Json& object);

}  // namespace psplit
