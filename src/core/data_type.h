// The types of values in a Draco stream.
#pragma once

#include <cstdint>

namespace psplit::core {

// The numbers are Draco's.
enum class DataType : uint8_t {
  kInt8 = 1,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat32,
  kFloat64,
  kBool,
};

}  // namespace psplit::core
