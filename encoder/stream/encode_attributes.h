// Encodes the attributes of a stream whose connectivity is known.
//
//   attribute_plan.h         which coding and which prediction; the literal bytes that state them
//   attribute_values.h       values -> integers
//   attribute_corrections.h  integers -> stored corrections, on the tables that a decoder has
//   crease_choice.h          which parallelograms predict a value
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "encoder/fields/draco_fields.h"
#include "encoder/stream/attribute_plan.h"
#include "encoder/welding/weld.h"
#include "psplit/base.h"
#include "psplit/encode.h"
#include "src/core/attributes.h"

namespace psplit {

// The input: a part of a welded mesh, with a coding for each of the mesh's attributes.
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

// Encodes one attribute after the other, in the order of the stream.
class AttributeEncoder {
 public:
  // `has_grids`: the plans' grids are final. For groups and point_of_corner see encode_attributes.
  AttributeEncoder(const AttributeSource& source, bool has_grids, std::span<const core::Group<uint32_t>> groups,
                   std::span<const uint32_t> point_of_corner)
      : source_(source), has_grids_(has_grids), groups_(groups), point_of_corner_(point_of_corner) {}

  // Takes the values of an attribute in the order of its group, and sets the grid of its plan. POSITION comes
  // before attributes that are predicted from it.
  Status take(AttributePlan& plan, const core::Group<uint32_t>& group);
  // The fields of the attribute that was taken last, with the scheme of the plan. May be called with one scheme
  // after the other.
  Expected<AttributeFields> correct(const AttributePlan& plan, const core::Group<uint32_t>& group) const;

 private:
  const Attribute& mesh_attribute(const AttributePlan& plan) const {
    return source_.welded.mesh->attributes[plan.source];
  }
  // The mesh's row that has the value of a point.
  uint32_t row_of(const AttributePlan& plan, uint32_t point) const {
    return source_.welded.value_of_point[plan.source][source_.points[point]];
  }
  void find_points(const core::Group<uint32_t>& group);
  Status take_integers(const AttributePlan& plan, std::vector<int32_t>& values);

  const AttributeSource& source_;
  const bool has_grids_;
  const std::span<const core::Group<uint32_t>> groups_;
  const std::span<const uint32_t> point_of_corner_;
  core::Attribute<uint32_t> attribute_, positions_;
  std::vector<int32_t> values_, position_values_;
  std::vector<uint32_t> rows_;
  std::vector<uint32_t> point_of_vertex_;  // of the group that was taken last
  const uint32_t* walk_ = nullptr;         // its sequence
  std::vector<uint8_t> raw_;
};

// `groups` have tables and sequences: one for all attributes, or first of POSITION and then of the others in
// the order of the mesh (AttributePlan::group). point_of_corner has the part's point at each corner of their
// tables. plan_attributes describes texture_may_overflow. Errors: as correct_values and write_integers.
// Thread-safe.
Expected<EncodedAttributes> encode_attributes(const AttributeSource& source, const StreamTraits& traits,
                                              const std::function<bool(size_t)>& texture_may_overflow,
                                              std::span<const core::Group<uint32_t>> groups,
                                              std::span<const uint32_t> point_of_corner);

}  // namespace psplit
