// The types of values in a Draco stream, and of its attributes.
#pragma once

#include <cstdint>

namespace psplit {

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

// Draco's attribute types, with the numbers that Draco gives them.
enum class DracoSemantic : uint8_t { kPosition, kNormal, kColor, kTexCoord, kGeneric };

}  // namespace psplit
