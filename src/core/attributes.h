// The attributes of a patch: how a stream describes them. Draco bitstream specification 2.2, "attribute
// decoders".
#pragma once

#include "psplit/draco_types.h"
#include "src/core/components.h"
#include "src/core/traversal.h"

namespace psplit::core {

PSPLIT_HD constexpr uint32_t data_type_bytes(DataType type) {
  constexpr uint8_t kBytes[] = {0, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8, 1};
  return kBytes[static_cast<uint8_t>(type)];
}

// How values are stored. The numbers are Draco's.
enum class Coding : uint8_t { kRaw = 0, kInteger = 1, kQuantized = 2, kNormal = 3 };

inline constexpr uint32_t kMaxAttributes = 256;
inline constexpr uint32_t kMaxAttributeData = 128;  // connectivities of attributes with seams

// What a directory says about a stream, besides the stream's own header.
struct ValueCounts {
  uint32_t points = 0;
  uint32_t attributes = 0;
  uint32_t components = 0;  // of all attributes together
};

template <typename Index>
struct Attribute {
  static constexpr uint8_t kPosition = 0;

  uint8_t semantic = 0;  // Draco's attribute type
  DataType type = DataType::kFloat32;
  uint8_t components = 0;
  bool normalized = false;
  uint32_t unique_id = 0;
  Coding coding = Coding::kRaw;
  uint8_t group = 0;

  // The integers, by vertex of the group's table, value_stride apart; two for each normal. Not for kRaw: `raw`
  // points to its bytes in the stream, in the order of the group's sequence.
  View<int32_t> values;
  const uint8_t* raw = nullptr;
  // The bits of a component, if kQuantized or kNormal; and if kQuantized, the range of all components, and the
  // origin, which has a float for each component in the stream.
  uint8_t bits = 0;
  const uint8_t* origin = nullptr;
  float range = 0;

  PSPLIT_HD uint32_t value_components() const { return coding == Coding::kNormal ? 2 : components; }
  PSPLIT_HD uint32_t stride() const { return data_type_bytes(type) * components; }
  // The distance from one place on the grid to the next, if kQuantized.
  PSPLIT_HD float step() const { return range / static_cast<float>((1u << bits) - 1); }
};

// Attributes that share a corner table and a sequence.
template <typename Index>
struct Group {
  int8_t attribute_data = -1;  // the number of their seams; -1 if they have none
  bool per_corner = false;     // uses the table of its own attribute data
  bool by_prediction_degree = false;
  uint32_t first = 0, count = 0;  // of the patch's attributes
  AttributeTable<Index> table;
  Sequence<Index> sequence;
};

// Reads the descriptions of a group's attributes, without their codings, and appends them to `attributes`.
template <typename Index>
PSPLIT_HD Fault read_types(ByteReader& reader, uint8_t group_number, Group<Index>& group,
                           View<Attribute<Index>> attributes, uint32_t& attribute_count) {
  group.first = attribute_count;
  group.count = reader.varint();
  if (reader.truncated()) return Fault::kTruncated;
  if (group.count == 0 || group.count > attributes.size() - attribute_count) return Fault::kAttribute;
  attribute_count += group.count;
  for (uint32_t i = 0; i < group.count; ++i) {
    Attribute<Index>& attribute = attributes[group.first + i];
    attribute = {};
    attribute.semantic = reader.u8();
    const uint8_t type = reader.u8();
    attribute.components = reader.u8();
    attribute.normalized = reader.u8() != 0;
    attribute.unique_id = reader.varint();
    attribute.group = group_number;
    constexpr uint8_t kSemanticCount = 5;
    if (attribute.semantic >= kSemanticCount || type == 0 || type > static_cast<uint8_t>(DataType::kBool) ||
        attribute.components == 0)
      return reader.truncated() ? Fault::kTruncated : Fault::kAttribute;
    attribute.type = static_cast<DataType>(type);
  }
  return reader.truncated() ? Fault::kTruncated : Fault::kNone;
}

// Reads the descriptions, and then the codings of the attributes.
template <typename Index>
PSPLIT_HD Fault read_descriptions(ByteReader& reader, uint8_t group_number, Group<Index>& group,
                                  View<Attribute<Index>> attributes, uint32_t& attribute_count) {
  const Fault fault = read_types(reader, group_number, group, attributes, attribute_count);
  if (fault != Fault::kNone) return fault;
  for (uint32_t i = 0; i < group.count; ++i) {
    Attribute<Index>& attribute = attributes[group.first + i];
    const uint8_t coding = reader.u8();
    if (coding > static_cast<uint8_t>(Coding::kNormal)) return Fault::kAttribute;
    attribute.coding = static_cast<Coding>(coding);
    const bool is_float = attribute.type == DataType::kFloat32;
    if ((attribute.coding == Coding::kQuantized && !is_float) ||
        (attribute.coding == Coding::kNormal && (!is_float || attribute.components != 3)) ||
        (attribute.coding == Coding::kInteger && attribute.type > DataType::kUint32))
      return Fault::kAttribute;
  }
  return reader.truncated() ? Fault::kTruncated : Fault::kNone;
}

// Reads the descriptions of all groups to `attributes`, which the arena took last or not at all. `read` is
// read_types or read_descriptions.
template <typename Index, typename Read>
PSPLIT_HD Fault read_attributes(ByteReader& reader, View<Group<Index>> groups, Arena& arena,
                                View<Attribute<Index>>& attributes, uint32_t& attribute_count, Read read) {
  // A description takes more than 4 bytes.
  const size_t most = reader.remaining() / 4 < kMaxAttributes ? reader.remaining() / 4 : kMaxAttributes;
  for (uint32_t g = 0; g < groups.size(); ++g) {
    ByteReader ahead = reader;
    const uint64_t count = uint64_t{attribute_count} + ahead.varint();
    arena.trim(attributes, 0);  // grows where it is
    if (!arena.take(attributes, count < most ? count : most)) return Fault::kWorkspace;
    const Fault fault = read(reader, static_cast<uint8_t>(g), groups[g], attributes, attribute_count);
    if (fault != Fault::kNone) return fault;
  }
  return Fault::kNone;
}

// Reads the numbers that turn integers into values of the attribute's own type.
template <typename Index>
PSPLIT_HD Fault read_transform(ByteReader& reader, Attribute<Index>& attribute) {
  if (attribute.coding == Coding::kQuantized) {
    attribute.origin = reader.head();
    reader.skip(uint64_t{attribute.components} * sizeof(float));
    attribute.range = reader.f32();
    attribute.bits = reader.u8();
    if (attribute.bits < 1 || attribute.bits > 30)
      return reader.truncated() ? Fault::kTruncated : Fault::kAttribute;
  } else if (attribute.coding == Coding::kNormal) {
    attribute.bits = reader.u8();
    if (attribute.bits < 2 || attribute.bits > 30)
      return reader.truncated() ? Fault::kTruncated : Fault::kAttribute;
  }
  return reader.truncated() ? Fault::kTruncated : Fault::kNone;
}

}  // namespace psplit::core
