// The types that values have in a Draco stream.
#pragma once

#include "psplit/draco_types.h"
#include "psplit/mesh.h"

namespace psplit {

// Draco's type for the components of an accessor.
constexpr DataType stored_type(ComponentType type) {
  switch (type) {
    case ComponentType::kInt8: return DataType::kInt8;
    case ComponentType::kUint8: return DataType::kUint8;
    case ComponentType::kInt16: return DataType::kInt16;
    case ComponentType::kUint16: return DataType::kUint16;
    case ComponentType::kUint32: return DataType::kUint32;
    case ComponentType::kFloat32: break;
  }
  return DataType::kFloat32;
}

}  // namespace psplit
