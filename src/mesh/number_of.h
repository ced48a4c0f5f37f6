// The number that a stored component means.
#pragma once

#include <algorithm>
#include <cstring>
#include <limits>
#include <type_traits>

#include "psplit/mesh.h"

namespace psplit {

// A fraction for normalized integers.
inline double number_of(const std::byte* component, ComponentType type, bool normalized) {
  const auto read = [&](auto value) {
    std::memcpy(&value, component, sizeof value);
    using Value = decltype(value);
    if constexpr (std::is_integral_v<Value>)
      if (normalized)
        return std::max(static_cast<double>(value) / static_cast<double>(std::numeric_limits<Value>::max()),
                        -1.0);
    return static_cast<double>(value);
  };
  switch (type) {
    case ComponentType::kInt8: return read(int8_t{});
    case ComponentType::kUint8: return read(uint8_t{});
    case ComponentType::kInt16: return read(int16_t{});
    case ComponentType::kUint16: return read(uint16_t{});
    case ComponentType::kUint32: return read(uint32_t{});
    case ComponentType::kFloat32: break;
  }
  return read(float{});
}

// The float at place `index` among all points' floats, of an attribute of floats.
inline float float_at(const Attribute& attribute, size_t index) {
  float value = 0;
  std::memcpy(&value, attribute.values.data() + index * sizeof value, sizeof value);
  return value;
}

}  // namespace psplit
