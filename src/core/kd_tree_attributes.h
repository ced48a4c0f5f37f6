// The attributes of a point cloud that is coded as kD-trees. The attributes of a group are the axes of one
// tree: floats as whole numbers on a grid, signed integers less the lowest of them.
//
// Bitstream 2.2 stores bits instead, of any attribute whose components have at most four bytes. Or, in a coding
// of its own, positions on a grid around the origin.
#pragma once

#include "src/core/cloud_header.h"
#include "src/core/kd_tree.h"
#include "src/core/patch.h"

namespace psplit::core {

template <typename Index>
class KdTreeAttributes {
 public:
  PSPLIT_HD KdTreeAttributes(const CloudHeader& header, Arena& arena, Patch<Index>& patch)
      : header_(header), reader_(header.body), arena_(arena), patch_(patch) {}

  // Reads groups and descriptions. The grids of a group follow its tree.
  PSPLIT_HD Fault outline() {
    patch_.point_count = header_.point_count;
    const uint32_t group_count = reader_.u8();
    if (reader_.truncated()) return Fault::kTruncated;
    if (group_count > kMaxAttributeData + 1) return Fault::kAttribute;
    if (!arena_.take(patch_.groups, group_count)) return Fault::kWorkspace;
    for (uint32_t g = 0; g < group_count; ++g) patch_.groups[g] = {};
    uint32_t attribute_count = 0;
    Fault fault =
        read_attributes(reader_, patch_.groups, arena_, patch_.attributes, attribute_count, read_types<Index>);
    for (uint32_t i = 0; i < attribute_count && fault == Fault::kNone; ++i)
      fault = choose_coding(patch_.attributes[i]);
    return fault;
  }
  PSPLIT_HD Fault decode() {
    Fault fault = outline();
    for (uint32_t g = 0; g < patch_.groups.size() && fault == Fault::kNone; ++g)
      fault = header_.minor == 2 ? decode_old(patch_.groups[g]) : decode(patch_.groups[g]);
    return fault;
  }

  // The memory that `decode` takes.
  PSPLIT_HD static size_t bytes(const ValueCounts& values) {
    const uint64_t places = uint64_t{values.points} * (uint64_t{values.components} + values.attributes);
    return Arena::bytes<Group<Index>>(values.attributes) + Arena::bytes<Attribute<Index>>(values.attributes) +
           Arena::bytes<int32_t>(places) + values.attributes * Arena::bytes<int32_t>(0) +
           Arena::bytes<TreeAxis>(values.components) + KdTree::bytes(values.points, values.components);
  }

 private:
  PSPLIT_HD static bool is_signed(DataType type) {
    return type == DataType::kInt8 || type == DataType::kInt16 || type == DataType::kInt32;
  }
  PSPLIT_HD View<Attribute<Index>> attributes_of(const Group<Index>& group) const {
    return {patch_.attributes.data() + group.first, group.count};
  }

  PSPLIT_HD Fault choose_coding(Attribute<Index>& attribute) const {
    const bool is_old = header_.minor == 2, is_float = attribute.type == DataType::kFloat32;
    attribute.coding = is_float && !is_old ? Coding::kQuantized : Coding::kInteger;
    const bool is_known =
        is_old ? data_type_bytes(attribute.type) <= 4 : attribute.type <= DataType::kUint32 || is_float;
    return is_known ? Fault::kNone : Fault::kAttribute;
  }

  PSPLIT_HD Fault decode(const Group<Index>& group) {
    const View<Attribute<Index>> attributes = attributes_of(group);
    const uint32_t level = reader_.u8();
    Fault fault = decode_tree(level, attributes);
    for (uint32_t i = 0; i < attributes.size() && fault == Fault::kNone; ++i)
      fault = read_transform(reader_, attributes[i]);
    for (uint32_t i = 0; i < attributes.size() && fault == Fault::kNone; ++i)
      if (is_signed(attributes[i].type)) fault = add_lowest(attributes[i]);
    return fault;
  }

  PSPLIT_HD Fault add_lowest(const Attribute<Index>& attribute) {
    const uint32_t stride = value_stride(attribute.components);
    for (uint32_t k = 0; k < attribute.components; ++k) {
      const auto lowest = static_cast<int32_t>(signed_of_symbol(reader_.varint()));
      bool is_negative = false;
      for (uint32_t i = 0; i < patch_.point_count; ++i) {
        int32_t& value = attribute.values[size_t{i} * stride + k];
        is_negative |= value < 0;
        value = wrapping_add(value, lowest);
      }
      if (is_negative && attribute.type == DataType::kInt32) return Fault::kAttribute;
    }
    return reader_.truncated() ? Fault::kTruncated : Fault::kNone;
  }

  PSPLIT_HD Fault decode_old(const Group<Index>& group) {
    const View<Attribute<Index>> attributes = attributes_of(group);
    constexpr uint8_t kOnGrid = 0, kBits = 1;
    const uint8_t method = reader_.u8(), level = reader_.u8();
    const uint32_t point_count = reader_.u32();
    if (reader_.truncated()) return Fault::kTruncated;
    if (method != kOnGrid && method != kBits) return Fault::kMethod;
    if (point_count != patch_.point_count) return Fault::kCounts;
    return method == kBits ? decode_tree(level, attributes) : decode_old_grid(attributes);
  }

  // Positions from -range to range, as whole numbers from 0. The level is stored once more.
  PSPLIT_HD Fault decode_old_grid(View<Attribute<Index>> attributes) {
    const Attribute<Index>& attribute = attributes[0];
    if (attributes.size() != 1 || attribute.components != 3 || data_type_bytes(attribute.type) != 4)
      return Fault::kAttribute;
    constexpr uint32_t kFirstVersion = 2, kVersion = 3, kKdTree = 1;
    const uint32_t version = reader_.u32();
    const uint32_t method = version == kVersion ? reader_.u8() : kKdTree;
    const uint32_t bits = reader_.u32();
    const float range = reader_.f32();
    const uint32_t point_count = reader_.u32(), level = reader_.u32();
    if (reader_.truncated()) return Fault::kTruncated;
    if (version < kFirstVersion || version > kVersion || method != kKdTree) return Fault::kMethod;
    if (bits > 31) return Fault::kAttribute;
    if (point_count != patch_.point_count) return Fault::kCounts;
    // An empty tree is not stored.
    const Fault fault = point_count > 0               ? decode_tree(level, attributes)
                        : level <= KdTree::kMostLevel ? Fault::kNone
                                                      : Fault::kMethod;
    const auto most = static_cast<int32_t>((1u << bits) - 1);
    const float step = most > 0 ? range / static_cast<float>(most) : 1.0f;
    for (size_t i = 0; i < attribute.values.size() && fault == Fault::kNone; ++i) {
      const float value = static_cast<float>(wrapping_sub(attribute.values[i], most)) * step;
      copy_bytes(&attribute.values[i], &value, sizeof value);
    }
    return fault;
  }

  PSPLIT_HD Fault decode_tree(uint32_t level, View<Attribute<Index>> attributes) {
    if (level > KdTree::kMostLevel) return Fault::kMethod;
    uint32_t axis_count = 0;
    for (uint32_t i = 0; i < attributes.size(); ++i) {
      const uint32_t components = attributes[i].components;
      axis_count += components;
      if (!arena_.take(attributes[i].values, uint64_t{patch_.point_count} * value_stride(components)))
        return Fault::kWorkspace;
      // A value of three components has a fourth place.
      if (value_stride(components) != components) fill(attributes[i].values, 0);
    }
    const size_t mark = arena_.mark();
    View<TreeAxis> axes;
    if (!arena_.take(axes, axis_count)) return Fault::kWorkspace;
    for (uint32_t i = 0, axis = 0; i < attributes.size(); ++i)
      for (uint32_t k = 0; k < attributes[i].components; ++k) {
        axes[axis] = {};
        axes[axis].values = attributes[i].values;
        axes[axis].component = k;
        axes[axis++].stride = value_stride(attributes[i].components);
      }
    KdTree tree;
    Fault fault = tree.start(reader_, static_cast<uint8_t>(level), patch_.point_count, axes, arena_);
    if (fault == Fault::kNone) {
      while (tree.running()) tree.step();
      fault = tree.fault();
    }
    arena_.release(mark);
    return fault;
  }

  const CloudHeader& header_;
  ByteReader reader_;
  Arena& arena_;
  Patch<Index>& patch_;
};

}  // namespace psplit::core
