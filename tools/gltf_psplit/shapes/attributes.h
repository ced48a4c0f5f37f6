// Attributes of generated meshes, and the limits of their faces.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>

#include "psplit/mesh.h"

namespace psplit {

inline Attribute make_attribute(const char* semantic, uint8_t component_count, size_t point_count,
                                ComponentType type = ComponentType::kFloat32) {
  Attribute attribute;
  attribute.semantic = semantic;
  attribute.component_type = type;
  attribute.component_count = component_count;
  attribute.values.resize(point_count * attribute.stride());
  return attribute;
}

template <typename T, size_t kCount>
void store(Attribute& attribute, size_t point, const std::array<T, kCount>& value) {
  std::memcpy(attribute.values.data() + point * sizeof(value), value.data(), sizeof(value));
}

// One value of floats for each point.
template <size_t kCount>
Attribute attribute_of(const char* semantic, std::span<const std::array<float, kCount>> values) {
  Attribute attribute = make_attribute(semantic, kCount, values.size());
  std::memcpy(attribute.values.data(), values.data(), attribute.values.size());
  return attribute;
}

// The numbers of faces that shapes can have. Errors: kUsage.
Status check_face_count(uint64_t faces);

}  // namespace psplit
