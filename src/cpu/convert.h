// Converts values from the type that a stream stores to the type that an accessor declares, which may differ in
// real assets. The rules are libdraco's.
#pragma once

#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "src/core/attributes.h"
#include "src/mesh/mesh.h"

namespace psplit {

// Returns false if the value does not fit.
template <typename From, typename To>
bool convert_component(From value, bool normalized, To& out) {
  if constexpr (std::is_integral_v<To>) {
    if constexpr (std::is_floating_point_v<From>) {
      if (normalized) {
        if (!(value >= 0 && value <= 1)) return false;
        out = static_cast<To>(std::floor(value * static_cast<double>(std::numeric_limits<To>::max()) + 0.5));
        return true;
      }
      if (!(value >= static_cast<From>(std::numeric_limits<To>::min()) &&
            value < static_cast<From>(std::numeric_limits<To>::max())))
        return false;
    } else if constexpr (!std::is_same_v<From, bool>) {
      if (!std::in_range<To>(value)) return false;
    }
    out = static_cast<To>(value);
  } else {
    out = static_cast<To>(value);
    if constexpr (std::is_integral_v<From>)
      if (normalized) out /= static_cast<To>(std::numeric_limits<From>::max());
  }
  return true;
}

template <typename From>
bool convert_value(const std::byte* in, ComponentType type, bool normalized, uint8_t components,
                   std::byte* out) {
  const auto to = [&]<typename To>(To) {
    for (uint8_t k = 0; k < components; ++k) {
      From value{};
      To converted{};
      if constexpr (std::is_same_v<From, bool>)
        value = in[k] != std::byte{0};  // a stream may hold any byte
      else
        std::memcpy(&value, in + k * sizeof(From), sizeof(From));
      if (!convert_component(value, normalized, converted)) return false;
      std::memcpy(out + k * sizeof(To), &converted, sizeof(To));
    }
    return true;
  };
  switch (type) {
    case ComponentType::kInt8: return to(int8_t{});
    case ComponentType::kUint8: return to(uint8_t{});
    case ComponentType::kInt16: return to(int16_t{});
    case ComponentType::kUint16: return to(uint16_t{});
    case ComponentType::kUint32: return to(uint32_t{});
    case ComponentType::kFloat32: return to(float{});
  }
  return false;
}

// Converts one value. `stored`, `normalized` and `components` are the stream's.
inline bool convert_value(const std::byte* in, core::DataType stored, bool normalized, ComponentType type,
                          uint8_t components, std::byte* out) {
  switch (stored) {
    case core::DataType::kInt8: return convert_value<int8_t>(in, type, normalized, components, out);
    case core::DataType::kUint8: return convert_value<uint8_t>(in, type, normalized, components, out);
    case core::DataType::kInt16: return convert_value<int16_t>(in, type, normalized, components, out);
    case core::DataType::kUint16: return convert_value<uint16_t>(in, type, normalized, components, out);
    case core::DataType::kInt32: return convert_value<int32_t>(in, type, normalized, components, out);
    case core::DataType::kUint32: return convert_value<uint32_t>(in, type, normalized, components, out);
    case core::DataType::kInt64: return convert_value<int64_t>(in, type, normalized, components, out);
    case core::DataType::kUint64: return convert_value<uint64_t>(in, type, normalized, components, out);
    case core::DataType::kFloat32: return convert_value<float>(in, type, normalized, components, out);
    case core::DataType::kFloat64: return convert_value<double>(in, type, normalized, components, out);
    case core::DataType::kBool: return convert_value<bool>(in, type, normalized, components, out);
  }
  return false;
}

}  // namespace psplit
