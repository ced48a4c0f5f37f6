// One Draco stream that may be condensed: its fields, and the values of its attributes.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "encoder/fields/draco_fields.h"
#include "src/core/decode_patch.h"

namespace psplit {

// The fields, if they follow all rules of condensed streams and come back from them. `face_count` is what the
// directory says.
std::optional<DracoFields> condensable_fields(std::span<const uint8_t> draco_stream, uint32_t face_count);

// A decoded stream: its corner tables, and its values.
class DecodedSource {
 public:
  // Null if the core does not decode the stream.
  static std::unique_ptr<DecodedSource> decode(std::span<const uint8_t> draco_stream, uint32_t point_count,
                                               const DracoFields& fields);

  const core::Attribute<uint32_t>& attribute(uint32_t number) const { return patch_.attributes[number]; }
  // The table of the attribute's group.
  const core::AttributeTable<uint32_t>& table(uint32_t number) const {
    return patch_.groups[attribute(number).group].table;
  }
  // The vertices of the first attribute's table at the places of the border walk.
  const std::vector<uint32_t>& walk() const { return walk_; }
  // A component of the value of a vertex of the table.
  int32_t number(uint32_t attribute, uint32_t vertex, uint32_t component) const {
    const core::Attribute<uint32_t>& from = this->attribute(attribute);
    return from.values[size_t{vertex} * core::value_stride(from.value_components()) + component];
  }

 private:
  std::unique_ptr<uint8_t[]> memory_;
  core::Patch<uint32_t> patch_;
  std::vector<uint32_t> walk_;
};

}  // namespace psplit
