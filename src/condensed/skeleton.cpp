#include "src/condensed/skeleton.h"

#include "src/condensed/stream_layout.h"

namespace psplit {
namespace {

// Notes what StreamLayout meets. All fields are empty.
class SkeletonReader {
 public:
  explicit SkeletonReader(std::span<const uint8_t> bytes) : literals_(bytes) {}

  Expected<Skeleton> read() {
    if (Status status = StreamLayout(*this).walk(); !status.ok()) return status;
    return std::move(skeleton_);
  }

  Literals& literals() { return literals_; }
  static Status counts() { return {}; }
  Status connectivity(bool is_valence, uint32_t data_count) {
    skeleton_.is_valence = is_valence;
    skeleton_.data_count = data_count;
    return {};
  }
  uint32_t value_count(const core::Group<uint32_t>& group) {
    skeleton_.groups.push_back(group);
    return 0;
  }
  Status raw(uint32_t, const core::Attribute<uint32_t>& description) {
    add(description).is_raw = true;
    return {};
  }
  Status symbols(uint32_t, const PredictedAttribute& predicted) {
    SkeletonAttribute& attribute = add(predicted.attribute);
    attribute.scheme = predicted.scheme;
    attribute.transform = predicted.transform;
    attribute.is_normal = predicted.attribute.coding == core::Coding::kNormal;
    const bool is_predicted = predicted.scheme != core::Scheme::kNone;
    attribute.scheme_at = literals_.position() - (is_predicted ? 3 : 2);
    if (!attribute.is_normal || !is_predicted) return {};
    // The grid's numbers follow, because the fields before them are empty.
    core::PredictionData data;
    data.transform = predicted.transform;
    core::ByteReader ahead = literals_;
    const core::Fault fault = data.read_grid(ahead);
    attribute.grid_max = data.grid.max_quantized();
    return fault_status(fault);
  }
  static Status creases() { return {}; }
  static Status orientations() { return {}; }
  static Status wrap() { return {}; }
  static Status flips() { return {}; }

 private:
  SkeletonAttribute& add(const core::Attribute<uint32_t>& description) {
    SkeletonAttribute& attribute = skeleton_.attributes.emplace_back();
    attribute.components = description.value_components();
    attribute.component_bytes = core::data_type_bytes(description.type);
    attribute.group = static_cast<uint32_t>(skeleton_.groups.size()) - 1;
    return attribute;
  }

  Literals literals_;
  Skeleton skeleton_;
};

}  // namespace

Expected<Skeleton> read_skeleton(std::span<const uint8_t> literals) { return SkeletonReader(literals).read(); }

}  // namespace psplit
