#include "encoder/stream/cloud_stream.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>

#include "encoder/fields/entropy_encoder.h"
#include "encoder/stream/attribute_values.h"
#include "encoder/stream/kd_tree_encoder.h"
#include "encoder/stream/sequential_stream.h"
#include "encoder/welding/weld.h"
#include "src/container/bit_string.h"
#include "src/container/claims.h"
#include "src/core/decode_cloud.h"
#include "src/core/stitch_codes.h"

namespace psplit {
namespace {

using core::Coding;

constexpr uint32_t kMostInt = 0x7fffffff, kMostPoints = kMostInt;

bool is_signed(DataType type) {
  return type == DataType::kInt8 || type == DataType::kInt16 || type == DataType::kInt32;
}

// The values of a cloud as a tree, attribute by attribute.
class TreeStream {
 public:
  TreeStream(const Mesh& cloud, std::span<const AttributeCoding> codings, int speed,
             std::span<const DracoLabel> labels, std::vector<uint32_t> points)
      : cloud_(cloud), codings_(codings), speed_(speed), labels_(labels), points_(std::move(points)) {}

  Expected<EncodedCloud> write() {
    plans_ = plan_attributes(cloud_, {}, codings_,
                             {.speed = speed_,
                              .point_count = cloud_.point_count,
                              .is_sequential = true,
                              .is_cloud = true,
                              .labels = labels_},
                             [](size_t) { return false; });
    uint32_t axis_count = 0;
    for (const AttributePlan& plan : plans_) axis_count += plan.description.components;
    tree_ = TreePoints(axis_count, cloud_.point_count);
    uint32_t first_axis = 0;
    for (AttributePlan& plan : plans_) {
      if (Status status = take(plan, first_axis); !status.ok()) return status;
      first_axis += plan.description.components;
    }
    for (const uint32_t point : points_) tree_.rows[point * tree_.row_size() + tree_.axis_count] = point;

    // The version, a cloud, the method of a tree, and flags of which none is set.
    EncodedCloud out{{'D', 'R', 'A', 'C', 'O', 2, 3, 0, 1, 0, 0}, {}};
    append_u32(cloud_.point_count, out.bytes);
    constexpr uint8_t kGroups = 1;
    out.bytes.push_back(kGroups);
    append_varint(plans_.size(), out.bytes);
    for (const AttributePlan& plan : plans_) append_description(plan, out.bytes);
    const uint8_t level = tree_level(speed_, tree_.axis_count);
    out.bytes.push_back(level);
    out.source_point = encode_tree(std::move(tree_), level, out.bytes);
    for (const AttributePlan& plan : plans_) append_transform(plan, out.bytes);
    for (const int32_t lowest : lowest_) append_varint(static_cast<uint32_t>(core::fold(lowest)), out.bytes);
    return out;
  }

 private:
  Status take(AttributePlan& plan, uint32_t first_axis) {
    const Attribute& from = cloud_.attributes[plan.source];
    const bool is_float = plan.description.type == DataType::kFloat32;
    const uint32_t components = plan.description.components;
    const size_t stride = core::value_stride(components);
    if (is_float)
      if (Status status = take_grid(from, plan); !status.ok()) return status;
    AttributePlan all_bits = plan;
    if (!is_float) all_bits.description.type = DataType::kInt32;  // also of unsigned integers
    values_.resize(points_.size() * stride);
    if (Status status = write_integers(from, all_bits, points_, values_); !status.ok()) return status;
    std::vector<int32_t> lowest(components);
    if (is_signed(plan.description.type))
      if (Status status = find_lowest(from, stride, lowest); !status.ok()) return status;
    uint32_t* to = tree_.rows.data() + first_axis;
    for (size_t at = 0; at < values_.size(); at += stride, to += tree_.row_size())
      for (uint32_t k = 0; k < components; ++k)
        to[k] = static_cast<uint32_t>(values_[at + k]) - static_cast<uint32_t>(lowest[k]);
    return {};
  }

  // Signed integers are stored less the lowest of their component.
  Status find_lowest(const Attribute& from, size_t stride, std::vector<int32_t>& lowest) {
    for (uint32_t k = 0; k < lowest.size(); ++k) {
      lowest[k] = std::numeric_limits<int32_t>::max();
      int32_t highest = std::numeric_limits<int32_t>::min();
      for (size_t at = k; at < values_.size(); at += stride) {
        lowest[k] = std::min(lowest[k], values_[at]);
        highest = std::max(highest, values_[at]);
      }
      if (int64_t{highest} - lowest[k] > std::numeric_limits<int32_t>::max())
        return unsupported(from.semantic + ": integers 2^31 and more apart");
    }
    lowest_.insert(lowest_.end(), lowest.begin(), lowest.end());
    return {};
  }

  // Normals have three components here, too.
  Status take_grid(const Attribute& from, AttributePlan& plan) {
    const AttributeCoding& grid = codings_[plan.source];
    if (grid.bits == 0 || grid.origin.size() != plan.description.components)
      return invalid_input(from.semantic + ": a kD-tree has floats only on a grid of their components");
    plan.description.coding = Coding::kQuantized;
    plan.description.bits = static_cast<uint8_t>(grid.bits);
    plan.description.range = grid.range;
    plan.origin = grid.origin;
    plan.transform = core::Transform::kWrap;
    if (labels_.empty()) set_stream_grid(from, grid, points_, plan);
    return {};
  }

  const Mesh& cloud_;
  const std::span<const AttributeCoding> codings_;
  const int speed_;
  const std::span<const DracoLabel> labels_;
  const std::vector<uint32_t> points_;  // all, in their order
  std::vector<AttributePlan> plans_;
  TreePoints tree_{0, 0};
  Array<int32_t> values_;        // of one attribute
  std::vector<int32_t> lowest_;  // of each component of signed integers
};

// Where sums of a prediction and a correction exceed 32 bits, no decoder finds the value.
Status check_sums(const Attribute& attribute) {
  if (attribute.component_type != ComponentType::kUint32 || attribute.values.empty()) return {};
  uint32_t low = ~uint32_t{0}, high = 0;
  for (size_t at = 0; at < attribute.values.size(); at += sizeof(uint32_t)) {
    uint32_t value;
    std::memcpy(&value, attribute.values.data() + at, sizeof value);
    low = std::min(low, value);
    high = std::max(high, value);
  }
  return uint64_t{high} + (high - low) < kMostInt
             ? Status()
             : unsupported(attribute.semantic + ": only a kD-tree holds integers of such a range");
}

std::vector<uint32_t> all_points(const Mesh& cloud) {
  std::vector<uint32_t> points(cloud.point_count);
  std::iota(points.begin(), points.end(), 0u);
  return points;
}

Expected<EncodedCloud> encode_as_tree(const Mesh& cloud, std::span<const AttributeCoding> codings, int speed,
                                      std::span<const DracoLabel> labels) {
  return TreeStream(cloud, codings, speed, labels, all_points(cloud)).write();
}

Expected<EncodedCloud> encode_in_order(const Mesh& cloud, std::span<const AttributeCoding> codings, int speed,
                                       std::span<const DracoLabel> labels) {
  std::vector<uint32_t> points = all_points(cloud);
  for (const Attribute& attribute : cloud.attributes)
    if (labels.empty())
      if (Status status = check_sums(attribute); !status.ok()) return status;
  const WeldedMesh apart{&cloud, std::vector(cloud.attributes.size(), points)};
  Expected<std::vector<uint8_t>> bytes = write_sequential_cloud({apart, codings, points}, speed, labels);
  if (!bytes) return bytes.status();
  return EncodedCloud{std::move(*bytes), std::move(points)};
}

}  // namespace

bool becomes_tree(const Mesh& cloud, std::span<const AttributeCoding> codings, int speed) {
  bool is_tree = speed < kMostEncodeSpeed;
  for (size_t i = 0; i < codings.size(); ++i)
    is_tree &= cloud.attributes[i].component_type != ComponentType::kFloat32 ||
               (codings[i].bits > 0 && !codings[i].octahedral);
  return is_tree;
}

Expected<EncodedCloud> encode_cloud(const Mesh& cloud, std::span<const AttributeCoding> codings, bool is_tree,
                                    int speed, std::span<const DracoLabel> labels) {
  if (cloud.point_count == 0) return invalid_input("a point cloud without points");
  if (cloud.attributes.empty()) return invalid_input("a point cloud without attributes");
  if (cloud.point_count > kMostPoints)
    return unsupported(std::to_string(cloud.point_count) + " points are too many for a point cloud");
  for (const Attribute& attribute : cloud.attributes)
    if (attribute.values.size() != attribute.stride() * cloud.point_count)
      return invalid_input(attribute.semantic + " has values for another number of points");
  Expected<EncodedCloud> encoded =
      is_tree ? encode_as_tree(cloud, codings, speed, labels) : encode_in_order(cloud, codings, speed, labels);
  // A section's length has 32 bits.
  if (encoded && encoded->bytes.size() > 0xffffffffu)
    return unsupported("the points take more than 4 GB as a point cloud");
  return encoded;
}

Expected<Mesh> decode_cloud(const Mesh& cloud, std::span<const uint8_t> stream) {
  core::ValueCounts counts{cloud.point_count, static_cast<uint32_t>(cloud.attributes.size()), 0};
  for (const Attribute& attribute : cloud.attributes) counts.components += attribute.component_count;
  core::CloudHeader header;
  const auto refused = [](core::Fault fault) {
    return runtime_failure("an encoded point cloud is refused: " + status_of(fault).to_string());
  };
  if (const core::Fault fault = core::read_cloud_header(stream.data(), stream.size(), header);
      fault != core::Fault::kNone)
    return refused(fault);
  const auto patch = std::make_unique<core::Patch<uint32_t>>();
  const size_t size = core::cloud_workspace_bytes<uint32_t>(header, stream.size(), counts);
  const std::unique_ptr<uint8_t[]> memory(new uint8_t[size]);
  core::Arena arena(memory.get(), size);
  if (const core::Fault fault = core::decode_cloud<uint32_t>(header, arena, *patch);
      fault != core::Fault::kNone)
    return refused(fault);
  Mesh decoded{patch->point_count, {}, {}};
  const std::vector<size_t> order = attribute_order(cloud);
  if (patch->attributes.size() != order.size())
    return runtime_failure("an encoded point cloud lost an attribute");
  decoded.attributes.resize(order.size());
  for (uint32_t i = 0; i < order.size(); ++i) {
    const Attribute& of = cloud.attributes[order[i]];
    Attribute& attribute = decoded.attributes[order[i]];
    attribute = {of.semantic, of.component_type, of.component_count, of.normalized, {}};
    const size_t stride = patch->attributes[i].stride();
    attribute.values.resize(decoded.point_count * stride);
    auto* const values = reinterpret_cast<uint8_t*>(attribute.values.data());
    patch->write_values(patch->attributes[i], [=](uint32_t point) { return values + point * stride; });
  }
  return decoded;
}

}  // namespace psplit
