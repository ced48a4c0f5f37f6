// libdraco's types and psplit's.
#pragma once

#include <draco/attributes/point_attribute.h>

#include "psplit/decode.h"

namespace psplit {

inline draco::DataType draco_type(ComponentType type) {
  switch (type) {
    case ComponentType::kInt8: return draco::DT_INT8;
    case ComponentType::kUint8: return draco::DT_UINT8;
    case ComponentType::kInt16: return draco::DT_INT16;
    case ComponentType::kUint16: return draco::DT_UINT16;
    case ComponentType::kUint32: return draco::DT_UINT32;
    case ComponentType::kFloat32: return draco::DT_FLOAT32;
  }
  return draco::DT_INVALID;
}

// Types and semantics have the same numbers in both libraries. The bits of quantization stay unknown.
inline StreamAttribute describe_attribute(const draco::PointAttribute& source) {
  StreamAttribute attribute;
  attribute.unique_id = source.unique_id();
  attribute.semantic = static_cast<DracoSemantic>(source.attribute_type());
  attribute.type = static_cast<DataType>(source.data_type());
  attribute.components = static_cast<uint8_t>(source.num_components());
  attribute.normalized = source.normalized();
  return attribute;
}

}  // namespace psplit
