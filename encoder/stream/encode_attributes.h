// The attributes of a stream whose connectivity is known.
//
//   attribute_plan.h         which coding and which prediction; the literal bytes that say so
//   attribute_values.h       values -> integers
//   attribute_corrections.h  integers -> what is stored, on the tables that a decoder has
//   crease_choice.h          which parallelograms predict a value
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "encoder/coding/attribute_coding.h"
#include "encoder/stream/attribute_plan.h"
#include "encoder/welding/weld.h"
#include "src/condensed/draco_fields.h"
#include "src/core/attributes.h"
#include "src/status.h"

namespace psplit {

// What is to be encoded: a part of a welded mesh, with a coding for each of the mesh's attributes.
struct AttributeSource {
  const WeldedMesh& welded;
  std::span<const AttributeCoding> codings;
  // For each point of the part the point of the mesh whose values are stored.
  std::span<const uint32_t> points;
};

struct EncodedAttributes {
  std::vector<AttributePlan> plans;  // in the order of the stream; their grids are libdraco's
  std::vector<AttributeFields> fields;
};

// `groups` have tables and sequences: one for all attributes, or that of POSITION and those of the others in
// the order of the mesh (AttributePlan::group). point_of_corner has the part's point at each corner of their
// tables. For texture_may_overflow see plan_attributes. Errors: those of correct_values and write_integers.
// Thread-safe.
Expected<EncodedAttributes> encode_attributes(const AttributeSource& source, const StreamTraits& traits,
                                              const std::function<bool(size_t)>& texture_may_overflow,
                                              std::span<const core::Group<uint32_t>> groups,
                                              std::span<const uint32_t> point_of_corner);

}  // namespace psplit
