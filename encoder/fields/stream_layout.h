// The layout of a Draco stream of Edgebreaker: the order of its literal bytes and of its fields. Draco
// bitstream specification 2.2. One walk serves two coders. The reader of fields takes the literal bytes from
// the stream itself. The writer takes them from the skeleton. The walk calls the coder wherever fields follow.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "psplit/base.h"
#include "src/container/claims.h"
#include "src/core/attributes.h"
#include "src/core/draco_header.h"
#include "src/core/prediction_data.h"

namespace psplit {

// Reads literal bytes, and copies them.
class Literals : public core::ByteReader {
 public:
  explicit Literals(std::span<const uint8_t> bytes) : ByteReader(bytes.data(), bytes.size()), bytes_(bytes) {}

  // Appends the bytes since the last call of either function.
  void copy_to(std::vector<uint8_t>& out) {
    const auto from = bytes_.begin();
    out.insert(out.end(), from + static_cast<std::ptrdiff_t>(done_),
               from + static_cast<std::ptrdiff_t>(position()));
    leave_out();
  }
  void leave_out() { done_ = position(); }

 private:
  std::span<const uint8_t> bytes_;
  size_t done_ = 0;
};

// An attribute of integers, and how they are predicted.
struct PredictedAttribute {
  const core::Attribute<uint32_t>& attribute;
  core::Scheme scheme;
  core::Transform transform;  // unless the scheme is kNone
};

// Walks through a stream. A Coder reads or writes fields. The walk calls its functions in this order:
//
//   Literals& literals();                                     at the start
//   Status counts();                                          the numbers of vertices and faces
//   Status connectivity(bool is_valence, uint32_t data_count);  from the number of symbols to seams and lists
//   uint32_t value_count(const Group&);                       for each group; then for each of its attributes:
//   Status raw(uint32_t count, const Attribute&);             the values of an attribute that is stored raw
//   Status symbols(uint32_t count, const PredictedAttribute&);  the symbols of any other attribute, and for it
//   Status creases(), orientations(), wrap(), flips();        functions that its prediction needs
//
// The literal bytes may be anything. The walk checks them as the decoder does.
template <typename Coder>
class StreamLayout {
 public:
  explicit StreamLayout(Coder& coder) : coder_(coder), literals_(coder.literals()) {}

  Status walk() {
    Status status = walk_connectivity();
    if (status.ok()) status = read_descriptions();
    for (uint32_t g = 0; g < groups_.size() && status.ok(); ++g) status = walk_group(groups_[g]);
    if (status.ok() && literals_.truncated()) status = status_of(core::Fault::kTruncated);
    return status;
  }

 private:
  using Group = core::Group<uint32_t>;
  using Attribute = core::Attribute<uint32_t>;

  Status walk_connectivity() {
    core::DracoHeader header;
    core::Fault fault = core::read_kind(literals_.head(), literals_.remaining(), header);
    if (fault == core::Fault::kNone && !header.edgebreaker) fault = core::Fault::kMethod;
    if (fault == core::Fault::kNone) fault = core::read_traversal(header);
    if (fault != core::Fault::kNone) return status_of(fault);
    literals_.skip(header.body.position());
    if (Status status = coder_.counts(); !status.ok()) return status;
    data_count_ = literals_.u8();
    if (data_count_ > core::kMaxAttributeData) return status_of(core::Fault::kAttribute);
    return coder_.connectivity(header.valence, data_count_);
  }

  Status read_descriptions() {
    const uint32_t group_count = literals_.u8();
    if (group_count > core::kMaxAttributeData + 1) return status_of(core::Fault::kAttribute);
    groups_.resize(group_count);
    for (Group& group : groups_) {
      group.attribute_data = static_cast<int8_t>(literals_.u8());
      group.per_corner = literals_.u8() != 0;
      group.by_prediction_degree = literals_.u8() == 1;
      const int64_t data = group.attribute_data;
      if (data >= int64_t{data_count_} || (data < 0 && group.per_corner))
        return status_of(core::Fault::kAttribute);
    }
    // A description takes more than 4 bytes.
    attributes_.resize(std::min<size_t>(literals_.remaining() / 4, core::kMaxAttributes));
    const core::View<Attribute> all(attributes_.data(), attributes_.size());
    uint32_t attribute_count = 0;
    for (uint32_t g = 0; g < group_count; ++g)
      if (const core::Fault fault =
              core::read_descriptions(literals_, static_cast<uint8_t>(g), groups_[g], all, attribute_count);
          fault != core::Fault::kNone)
        return status_of(fault);
    return {};
  }

  Status walk_group(const Group& group) {
    const uint32_t count = coder_.value_count(group), end = group.first + group.count;
    for (uint32_t i = group.first; i < end; ++i)
      if (Status status = walk_attribute(count, attributes_[i]); !status.ok()) return status;
    for (uint32_t i = group.first; i < end; ++i)
      if (const core::Fault fault = core::read_transform(literals_, attributes_[i]);
          fault != core::Fault::kNone)
        return status_of(fault);
    return {};
  }

  Status walk_attribute(uint32_t count, const Attribute& attribute) {
    using core::Scheme;
    if (attribute.coding == core::Coding::kRaw) return coder_.raw(count, attribute);
    const auto scheme = static_cast<Scheme>(literals_.u8());
    const bool is_normal = attribute.coding == core::Coding::kNormal, is_predicted = scheme != Scheme::kNone;
    auto transform = core::Transform::kWrap;
    if (is_predicted) {
      transform = static_cast<core::Transform>(literals_.u8());
      const bool is_wrap = transform == core::Transform::kWrap;
      if (is_wrap == is_normal || transform < core::Transform::kWrap ||
          transform > core::Transform::kOctahedronCanonicalized)
        return status_of(core::Fault::kMethod);
    }
    constexpr int8_t kDeprecated = 3, kMost = 6;
    const auto number = static_cast<int8_t>(scheme);
    const bool fits =
        is_normal ? number <= 0 || scheme == Scheme::kGeometricNormal : scheme != Scheme::kGeometricNormal;
    if (number < -2 || number == -1 || number == kDeprecated || number > kMost || !fits)
      return unsupported("a prediction scheme that is deprecated, or that does not fit its attribute");
    const uint8_t is_entropy_coded = literals_.u8();
    if (literals_.truncated()) return status_of(core::Fault::kTruncated);
    if (is_entropy_coded == 0) return unsupported("integers that are not entropy-coded");

    Status status = coder_.symbols(count, {attribute, scheme, transform});
    if (status.ok() && scheme == Scheme::kConstrainedMultiParallelogram) status = coder_.creases();
    if (status.ok() && scheme == Scheme::kTexCoords) status = coder_.orientations();
    if (status.ok() && is_predicted && !is_normal) status = coder_.wrap();
    // The grid's largest number, and its center.
    if (is_predicted && is_normal)
      literals_.skip(transform == core::Transform::kOctahedronCanonicalized ? 2 * sizeof(uint32_t)
                                                                            : sizeof(uint32_t));
    if (status.ok() && scheme == Scheme::kGeometricNormal) status = coder_.flips();
    return status;
  }

  Coder& coder_;
  Literals& literals_;
  uint32_t data_count_ = 0;
  std::vector<Group> groups_;
  std::vector<Attribute> attributes_;
};

}  // namespace psplit
