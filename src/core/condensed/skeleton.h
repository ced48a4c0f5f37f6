// A first look at a skeleton, without memory: what the numbers of a condensed stream depend on. The decoder of
// attributes checks it all when it reads the skeleton again.
#pragma once

#include "src/core/attributes.h"
#include "src/core/condensed/models.h"
#include "src/core/prediction_data.h"

namespace psplit::core {

// An attribute as a skeleton describes it.
struct SkeletonAttribute {
  Coding coding = Coding::kRaw;
  Scheme scheme = Scheme::kNone;
  Transform transform = Transform::kWrap;
  uint8_t components = 0;  // in the stream; two for octahedral normals
  uint16_t scheme_at = 0;  // the place of the scheme's byte in the skeleton, unless values are raw

  bool operator==(const SkeletonAttribute&) const = default;

  PSPLIT_HD bool is_raw() const { return coding == Coding::kRaw; }
  // Whether values may be in order of creation.
  PSPLIT_HD bool allows_creation_order() const {
    return !is_raw() &&
           (scheme == Scheme::kNone || scheme == Scheme::kDifference || scheme == Scheme::kParallelogram);
  }
  PSPLIT_HD bool is_by_creation(const AttributeModel& model) const {
    return model.by_creation && allows_creation_order();
  }
  // Whether a wrap range is stored. Not asked if values are in order of creation.
  PSPLIT_HD bool has_wrap_range() const {
    return !is_raw() && scheme != Scheme::kNone && transform == Transform::kWrap;
  }
  // Whether corrections are on an octahedral grid.
  PSPLIT_HD bool has_grid() const {
    return !is_raw() && scheme != Scheme::kNone && transform != Transform::kWrap;
  }
  PSPLIT_HD uint32_t flag_lists() const {
    if (is_raw()) return 0;
    return scheme == Scheme::kConstrainedMultiParallelogram ? AttributeModel::kCreaseContexts
           : scheme == Scheme::kTexCoords                   ? 1
                                                            : 0;
  }
};

// Reads the attributes of a skeleton, at most attributes.size(). `reader` is right after the number of
// attribute data.
PSPLIT_HD inline Fault read_skeleton(ByteReader reader, View<SkeletonAttribute> attributes, uint32_t& count) {
  uint16_t group_ends[kMaxAttributeData + 1];
  const uint32_t group_count = reader.u8();
  if (group_count > kMaxAttributeData + 1) return Fault::kAttribute;
  reader.skip(uint64_t{3} * group_count);
  count = 0;
  for (uint32_t group = 0; group < group_count; ++group) {
    const uint32_t first = count, in_group = reader.varint();
    if (reader.truncated()) return Fault::kTruncated;
    if (in_group > attributes.size() - count) return Fault::kAttribute;
    count += in_group;
    group_ends[group] = static_cast<uint16_t>(count);
    for (uint32_t i = first; i < count; ++i) {
      reader.skip(2);
      attributes[i] = {};
      attributes[i].components = reader.u8();
      reader.skip(1);
      reader.varint();
    }
    for (uint32_t i = first; i < count; ++i) attributes[i].coding = static_cast<Coding>(reader.u8());
  }
  for (uint32_t group = 0, i = 0; group < group_count; ++group) {
    const uint32_t first = i;
    for (; i < group_ends[group]; ++i) {
      SkeletonAttribute& attribute = attributes[i];
      if (attribute.is_raw()) continue;
      attribute.scheme_at = static_cast<uint16_t>(reader.position());
      attribute.scheme = static_cast<Scheme>(reader.u8());
      if (attribute.scheme != Scheme::kNone) attribute.transform = static_cast<Transform>(reader.u8());
      reader.skip(1);
      if (attribute.has_grid()) reader.skip(attribute.transform == Transform::kOctahedronCanonicalized ? 8 : 4);
    }
    for (uint32_t k = first; k < i; ++k) {
      SkeletonAttribute& attribute = attributes[k];
      if (attribute.coding == Coding::kQuantized) reader.skip(uint64_t{4} * attribute.components + 5);
      if (attribute.coding == Coding::kNormal) {
        reader.skip(1);
        attribute.components = 2;
      }
    }
  }
  return reader.truncated() ? Fault::kTruncated : Fault::kNone;
}

}  // namespace psplit::core
