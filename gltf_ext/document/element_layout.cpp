#include "gltf_ext/document/element_layout.h"

#include "gltf_ext/json/json_fields.h"

namespace psplit {

Expected<ElementLayout> element_layout(const Json& accessor) {
  const auto component = integer_field(accessor, "componentType");
  const std::string* type = string_field(accessor, "type");
  if (!component || *component < 5120 || *component > 5126 || *component == 5124)
    return invalid_input("no valid componentType");
  ElementLayout layout{.component_type = static_cast<ComponentType>(*component)};
  struct Shape {
    const char* name;
    uint8_t rows, columns;
  };
  constexpr Shape kShapes[] = {{"SCALAR", 1, 1}, {"VEC2", 2, 1}, {"VEC3", 3, 1}, {"VEC4", 4, 1},
                               {"MAT2", 2, 2},   {"MAT3", 3, 3}, {"MAT4", 4, 4}};
  for (const Shape& shape : kShapes) {
    if (type == nullptr || *type != shape.name) continue;
    layout.rows = shape.rows;
    layout.columns = shape.columns;
    return layout;
  }
  return invalid_input("no valid type");
}

bool elements_fit(const ElementLayout& layout, uint64_t offset, uint64_t stride, uint64_t count,
                  uint64_t available) {
  if (offset > available) return false;
  if (count == 0) return true;
  if (available - offset < layout.last_bytes()) return false;
  return stride == 0 || count - 1 <= (available - offset - layout.last_bytes()) / stride;
}

}  // namespace psplit
