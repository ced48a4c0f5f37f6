#include "encoder/stream/sequential_stream.h"

#include <numeric>

#include "encoder/fields/entropy_encoder.h"
#include "src/container/bit_string.h"

namespace psplit {
namespace {

using Faces = std::span<const std::array<uint32_t, 3>>;

// The number of points decides how a point is stored.
std::vector<uint8_t> plain_indices(Faces faces, uint32_t point_count) {
  constexpr uint32_t kByte = 1u << 8, kTwoBytes = 1u << 16, kVarint = 1u << 21;
  std::vector<uint8_t> out;
  const size_t most = point_count < kByte ? 1 : point_count < kTwoBytes ? 2 : point_count < kVarint ? 3 : 4;
  out.reserve(1 + 3 * most * faces.size());
  constexpr uint8_t kPlain = 1;
  out.push_back(kPlain);
  for (const auto& face : faces)
    for (const uint32_t point : face) {
      if (point_count >= kTwoBytes && point_count < kVarint) {
        append_varint(point, out);
        continue;
      }
      for (size_t i = 0; i < most; ++i) out.push_back(static_cast<uint8_t>(point >> 8 * i));
    }
  return out;
}

// Differences from the index before: twice their magnitude, and one more below 0.
std::vector<uint8_t> compressed_indices(Faces faces) {
  std::vector<uint32_t> symbols;
  symbols.reserve(3 * faces.size());
  uint32_t last = 0;
  for (const auto& face : faces)
    for (const uint32_t point : face) {
      symbols.push_back(point < last ? (last - point) << 1 | 1 : (point - last) << 1);
      last = point;
    }
  constexpr uint8_t kCompressed = 0;
  std::vector<uint8_t> out = {kCompressed};
  encode_symbols(symbols, 1, kDefaultSymbolLevel, out);
  return out;
}

// A group whose vertices are the points, in their order. It needs no faces.
class PointsInOrder {
 public:
  explicit PointsInOrder(size_t point_count) : identity_(point_count + 1) {
    std::iota(identity_.begin(), identity_.end(), 0u);
    const core::View<uint32_t> points(identity_.data(), point_count);
    group_.table.table.vertex = points;
    group_.table.vertex_count = static_cast<uint32_t>(point_count);
    group_.sequence = {{identity_.data(), identity_.size()}, points, static_cast<uint32_t>(point_count)};
  }
  const core::Group<uint32_t>& group() const { return group_; }
  std::span<const uint32_t> point_of_corner() const { return identity_; }

 private:
  std::vector<uint32_t> identity_;
  core::Group<uint32_t> group_;
};

void append_attributes(const EncodedAttributes& attributes, int speed, std::vector<uint8_t>& out) {
  constexpr uint8_t kGroups = 1;
  out.push_back(kGroups);
  append_varint(attributes.plans.size(), out);
  for (const AttributePlan& plan : attributes.plans) append_description(plan, out);
  for (const AttributePlan& plan : attributes.plans)
    out.push_back(static_cast<uint8_t>(plan.description.coding));
  for (size_t i = 0; i < attributes.plans.size(); ++i) {
    const AttributePlan& plan = attributes.plans[i];
    const AttributeFields& fields = attributes.fields[i];
    out.insert(out.end(), fields.raw.begin(), fields.raw.end());
    append_scheme(plan, out);
    encode_symbols(fields.symbols, fields.components, symbol_level_of(speed), out);
    append_prediction_grid(plan, out);
    if (!plan.is_predicted() || plan.transform != core::Transform::kWrap) continue;
    append_u32(static_cast<uint32_t>(fields.wrap_min), out);
    append_u32(static_cast<uint32_t>(fields.wrap_max), out);
  }
  for (const AttributePlan& plan : attributes.plans) append_transform(plan, out);
}

// Encodes the values and appends them.
Status append_values(const AttributeSource& source, StreamTraits traits, std::vector<uint8_t>& out) {
  traits.point_count = static_cast<uint32_t>(source.points.size());
  traits.is_sequential = true;
  if (traits.point_count == 0) return invalid_input("a mesh without points");
  const PointsInOrder points(traits.point_count);
  const Expected<EncodedAttributes> attributes = encode_attributes(
      source, traits, [](size_t) { return false; }, {&points.group(), 1}, points.point_of_corner());
  if (attributes) append_attributes(*attributes, traits.speed, out);
  return attributes.status();
}

}  // namespace

Expected<std::vector<uint8_t>> write_sequential_stream(const AttributeSource& source, Faces faces, int speed,
                                                       std::span<const DracoLabel> labels) {
  std::vector<uint8_t> values;
  if (Status status = append_values(source, {.speed = speed, .labels = labels}, values); !status.ok())
    return status;
  const auto point_count = static_cast<uint32_t>(source.points.size());
  // The version, a mesh, the sequential method, and flags of which none is set.
  std::vector<uint8_t> head = {'D', 'R', 'A', 'C', 'O', 2, 2, 1, 0, 0, 0};
  append_varint(faces.size(), head);
  append_varint(point_count, head);
  constexpr size_t kMostHeaderBytes = 64;
  const size_t others = head.size() + values.size(), least = 3 * faces.size() + kMostHeaderBytes;
  std::vector<uint8_t> indices = plain_indices(faces, point_count);
  if (labels.empty()) {
    std::vector<uint8_t> smaller = compressed_indices(faces);
    if (smaller.size() < indices.size() && others + smaller.size() >= least) indices = std::move(smaller);
  }
  head.insert(head.end(), indices.begin(), indices.end());
  head.insert(head.end(), values.begin(), values.end());
  return head;
}

Expected<std::vector<uint8_t>> write_sequential_cloud(const AttributeSource& source, int speed,
                                                      std::span<const DracoLabel> labels) {
  // The version, a cloud, the sequential method, and flags of which none is set.
  std::vector<uint8_t> bytes = {'D', 'R', 'A', 'C', 'O', 2, 3, 0, 0, 0, 0};
  append_u32(static_cast<uint32_t>(source.points.size()), bytes);
  const StreamTraits traits{.speed = speed, .is_cloud = true, .labels = labels};
  if (Status status = append_values(source, traits, bytes); !status.ok()) return status;
  return bytes;
}

}  // namespace psplit
