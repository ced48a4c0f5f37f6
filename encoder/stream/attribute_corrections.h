// What libdraco's encoder stores for the values of an attribute: the inverse of core/prediction.h for all of
// its schemes.
#pragma once

#include "encoder/fields/draco_fields.h"
#include "psplit/base.h"
#include "src/core/attributes.h"
#include "src/core/prediction_data.h"

namespace psplit {

// An attribute of a stream: the group that it is in, its values, and how they are predicted.
//
// The values are in the tables of psplit's own connectivity decoder. Corrections depend only on data in the
// tables that a decoder knows as well, so they equal the corrections of an encoder with tables of its own.
struct ValuesToCorrect {
  const core::Group<uint32_t>& group;  // with its table and sequence
  // coding, type, components and bits; `values` by vertex of the table, value_stride apart, or `raw` in the
  // order of the sequence.
  const core::Attribute<uint32_t>& attribute;
  core::Scheme scheme = core::Scheme::kNone;
  core::Transform transform = core::Transform::kWrap;
  // The integer positions, which kTexCoords and kGeometricNormal predict from.
  const core::Group<uint32_t>* position_group = nullptr;
  const core::Attribute<uint32_t>* positions = nullptr;
};

// Returns the fields of the attribute as libdraco's encoder writes them, without `skeleton`, component_bytes
// and grid_size, which only readers set. Errors: kUnsupported for values that libdraco's encoder refuses or
// writes so that no decoder reads them: a range of 2^31 numbers, texture coordinates whose products overflow;
// and for schemes that it does not write. Thread-safe.
Expected<AttributeFields> correct_values(const ValuesToCorrect& of);

}  // namespace psplit
