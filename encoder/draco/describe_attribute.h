// Describes libdraco's attributes in psplit's types.
#pragma once

#include <draco/attributes/point_attribute.h>

#include "src/container/stream_description.h"

namespace psplit {

// Types and semantics have the same numbers in both libraries. The bits of quantization stay unknown.
inline StreamAttribute describe_attribute(const draco::PointAttribute& source) {
  StreamAttribute attribute;
  attribute.unique_id = source.unique_id();
  attribute.semantic = static_cast<DracoSemantic>(source.attribute_type());
  attribute.type = static_cast<core::DataType>(source.data_type());
  attribute.components = static_cast<uint8_t>(source.num_components());
  attribute.normalized = source.normalized();
  return attribute;
}

}  // namespace psplit
