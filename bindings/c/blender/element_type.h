// glTF's types as the add-on passes them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "psplit/mesh.h"

namespace psplit::blender {

inline std::optional<ComponentType> component_type_of(size_t type) {
  if (type < 5120 || type > 5126 || type == 5124) return std::nullopt;
  return static_cast<ComponentType>(type);
}

// Components of an element; 0 if there is no such type.
inline uint8_t component_count_of(const char* type) {
  struct Named {
    std::string_view name;
    uint8_t count;
  };
  constexpr Named kTypes[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4},
                              {"MAT2", 4},   {"MAT3", 9}, {"MAT4", 16}};
  for (const Named& known : kTypes)
    if (type != nullptr && known.name == type) return known.count;
  return 0;
}

}  // namespace psplit::blender
