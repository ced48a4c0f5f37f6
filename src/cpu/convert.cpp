#include "src/cpu/convert.h"

#include <cmath>
#include <cstring>

#include "src/core/attributes.h"

namespace psplit {
namespace {

// A component without its type: as an integer, or as a floating-point number. An unsigned number of 64 bits is
// kept as its bits.
struct Component {
  bool is_float = false;
  int64_t integer = 0;
  double real = 0;
};

bool is_float(DataType type) { return type == DataType::kFloat32 || type == DataType::kFloat64; }
bool is_signed(DataType type) {
  return type == DataType::kInt8 || type == DataType::kInt16 || type == DataType::kInt32 ||
         type == DataType::kInt64;
}
// The greatest number of an integer type.
uint64_t most(DataType type) {
  if (type == DataType::kBool) return 1;
  return ~uint64_t{0} >> (64 - 8 * core::data_type_bytes(type) + (is_signed(type) ? 1 : 0));
}

Component load(const uint8_t* in, DataType type) {
  Component component;
  component.is_float = is_float(type);
  const uint32_t bytes = core::data_type_bytes(type);
  if (type == DataType::kFloat32) {
    float value;
    std::memcpy(&value, in, sizeof value);
    component.real = static_cast<double>(value);
  } else if (type == DataType::kFloat64) {
    std::memcpy(&component.real, in, sizeof component.real);
  } else {
    uint64_t bits = 0;
    std::memcpy(&bits, in, bytes);
    const uint32_t unused = is_signed(type) ? 64 - 8 * bytes : 0;
    component.integer = static_cast<int64_t>(bits << unused) >> unused;
    // A bool that is neither 0 nor 1 is a mistake, but libdraco takes its byte.
  }
  return component;
}

template <typename Float>
Float to_float(const Component& component, DataType from, bool normalized) {
  if (component.is_float) return static_cast<Float>(component.real);
  const Float value = from == DataType::kUint64 ? static_cast<Float>(static_cast<uint64_t>(component.integer))
                                                : static_cast<Float>(component.integer);
  return normalized ? value / static_cast<Float>(most(from)) : value;
}

// Returns false if the number is out of the type's range.
bool to_integer(const Component& component, DataType from, bool normalized, DataType to, uint64_t& bits) {
  const uint64_t high = most(to);
  const int64_t low = is_signed(to) ? -static_cast<int64_t>(high) - 1 : 0;
  if (component.is_float) {
    double value = component.real;
    if (normalized) {
      if (!(value >= 0 && value <= 1)) return false;
      value = std::floor(value * static_cast<double>(high) + 0.5);
    } else if (!(value >= static_cast<double>(low) && value < static_cast<double>(high))) {
      return false;
    }
    bits = is_signed(to) ? static_cast<uint64_t>(static_cast<int64_t>(value)) : static_cast<uint64_t>(value);
    return true;
  }
  bits = static_cast<uint64_t>(component.integer);
  // libdraco compares a signed number of at most 32 bits with the limits as an unsigned one: it always fits.
  if (to == DataType::kUint32 && is_signed(from) && from <= DataType::kInt32) return true;
  const bool is_large = from == DataType::kUint64 && component.integer < 0;  // above all int64_t
  return is_large ? high == ~uint64_t{0} : component.integer >= low && (component.integer < 0 || bits <= high);
}

// Small integers as floats, which colours and quantized assets often are. Each is read before the place of a
// later one is written, where `in` lies at the end of `out`.
template <typename Integer>
void convert_to_floats(const uint8_t* in, float unit, size_t count, uint8_t* out) {
  for (size_t k = 0; k < count; ++k) {
    Integer value;
    std::memcpy(&value, in + k * sizeof value, sizeof value);
    const float converted = static_cast<float>(value) / unit;
    std::memcpy(out + k * sizeof converted, &converted, sizeof converted);
  }
}

}  // namespace

bool convert_components(const uint8_t* in, DataType from, bool normalized, size_t count, DataType to,
                        uint8_t* out) {
  if (to == DataType::kFloat32) {
    // A number that is divided by 1 stays as it is.
    const float unit = normalized && from <= DataType::kUint16 ? static_cast<float>(most(from)) : 1;
    switch (from) {
      case DataType::kInt8: return convert_to_floats<int8_t>(in, unit, count, out), true;
      case DataType::kUint8: return convert_to_floats<uint8_t>(in, unit, count, out), true;
      case DataType::kInt16: return convert_to_floats<int16_t>(in, unit, count, out), true;
      case DataType::kUint16: return convert_to_floats<uint16_t>(in, unit, count, out), true;
      default: break;
    }
  }
  const uint32_t in_bytes = core::data_type_bytes(from), out_bytes = core::data_type_bytes(to);
  for (size_t k = 0; k < count; ++k, in += in_bytes, out += out_bytes) {
    const Component component = load(in, from);
    uint64_t bits = 0;
    if (to == DataType::kFloat32) {
      const auto value = to_float<float>(component, from, normalized);
      std::memcpy(&bits, &value, sizeof value);
    } else if (to == DataType::kFloat64) {
      const auto value = to_float<double>(component, from, normalized);
      std::memcpy(&bits, &value, sizeof value);
    } else if (!to_integer(component, from, normalized, to, bits)) {
      return false;
    }
    std::memcpy(out, &bits, out_bytes);
  }
  return true;
}

}  // namespace psplit
