// The bounds of an attribute's values, as the accessors of glTF state them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>
#include <vector>

#include "src/mesh/mesh.h"

namespace psplit {

// The least and the largest finite value of each component. A component without finite values has a least value
// above the largest until finish().
struct ValueBounds {
  std::vector<double> least, most;

  // Values that are `stride` bytes apart. Each call has the same type and number of components.
  void add(ComponentType type, size_t component_count, const std::byte* values, size_t count, size_t stride) {
    if (least.empty()) {
      least.assign(component_count, std::numeric_limits<double>::infinity());
      most.assign(component_count, -std::numeric_limits<double>::infinity());
    }
    switch (type) {
      case ComponentType::kInt8: return add_as<int8_t>(values, count, stride);
      case ComponentType::kUint8: return add_as<uint8_t>(values, count, stride);
      case ComponentType::kInt16: return add_as<int16_t>(values, count, stride);
      case ComponentType::kUint16: return add_as<uint16_t>(values, count, stride);
      case ComponentType::kUint32: return add_as<uint32_t>(values, count, stride);
      case ComponentType::kFloat32: return add_as<float>(values, count, stride);
    }
  }
  // Without finite values, both are 0.
  void finish() {
    for (size_t c = 0; c < least.size(); ++c)
      if (least[c] > most[c]) least[c] = most[c] = 0;
  }

 private:
  template <typename T>
  void add_as(const std::byte* values, size_t count, size_t stride) {
    for (size_t c = 0; c < least.size(); ++c) {
      T low = std::numeric_limits<T>::max(), high = std::numeric_limits<T>::lowest();
      for (size_t i = 0; i < count; ++i) {
        T value;
        std::memcpy(&value, values + i * stride + c * sizeof(T), sizeof(T));
        if constexpr (std::is_floating_point_v<T>)
          if (!std::isfinite(value)) continue;
        low = std::min(low, value);
        high = std::max(high, value);
      }
      if (low > high) continue;
      least[c] = std::min(least[c], static_cast<double>(low));
      most[c] = std::max(most[c], static_cast<double>(high));
    }
  }
};

}  // namespace psplit
