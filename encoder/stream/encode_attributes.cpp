#include "encoder/stream/encode_attributes.h"

#include "encoder/stream/attribute_corrections.h"
#include "encoder/stream/attribute_values.h"

namespace psplit {
namespace {

class AttributeEncoder {
 public:
  // `has_grids`: the plans' grids are final.
  AttributeEncoder(const AttributeSource& source, bool has_grids, std::span<const core::Group<uint32_t>> groups,
                   std::span<const uint32_t> point_of_corner)
      : source_(source), has_grids_(has_grids), groups_(groups), point_of_corner_(point_of_corner) {}

  Status encode(EncodedAttributes& out) {
    for (AttributePlan& plan : out.plans) {
      const core::Group<uint32_t>& group = groups_[plan.group];
      const bool is_position =
          static_cast<DracoSemantic>(plan.description.semantic) == DracoSemantic::kPosition;
      core::Attribute<uint32_t> attribute = plan.description;
      if (Status status = take_values(group, plan, attribute); !status.ok()) return status;
      if (is_position) positions_ = attribute;
      Expected<AttributeFields> fields =
          correct_values({group, attribute, plan.scheme, plan.transform, &groups_[0], &positions_});
      if (!fields) return unsupported(mesh_attribute(plan).semantic + ": " + fields.status().message());
      out.fields.push_back(std::move(*fields));
      // Other attributes are predicted from positions.
      if (is_position) position_values_ = std::move(values_);
    }
    return {};
  }

 private:
  const Attribute& mesh_attribute(const AttributePlan& plan) const {
    return source_.welded.mesh->attributes[plan.source];
  }
  // The mesh's row that has the value of a point.
  uint32_t row_of(const AttributePlan& plan, uint32_t point) const {
    return source_.welded.value_of_point[plan.source][source_.points[point]];
  }

  Status take_values(const core::Group<uint32_t>& group, AttributePlan& plan,
                     core::Attribute<uint32_t>& attribute) {
    const Attribute& from = mesh_attribute(plan);
    const bool is_raw = attribute.coding == core::Coding::kRaw;
    if (attribute.coding == core::Coding::kQuantized && !has_grids_) {
      rows_.resize(source_.points.size());
      for (uint32_t point = 0; point < rows_.size(); ++point) rows_[point] = row_of(plan, point);
      set_stream_grid(from, source_.codings[plan.source], rows_, plan);
    }
    // A value is that of the point at which a walk meets it.
    rows_.resize(group.sequence.count);
    for (uint32_t i = 0; i < group.sequence.count; ++i) {
      const uint32_t corner = group.sequence.corner[i];
      rows_[is_raw ? i : group.table.table.vertex[corner]] = row_of(plan, point_of_corner_[corner]);
    }
    if (is_raw) {
      raw_ = raw_values(from, rows_);
      attribute.raw = raw_.data();
      return {};
    }
    values_.resize(rows_.size() * core::value_stride(attribute.value_components()));
    attribute.values = {values_.data(), values_.size()};
    return write_integers(from, plan, rows_, values_);
  }

  const AttributeSource& source_;
  const bool has_grids_;
  const std::span<const core::Group<uint32_t>> groups_;
  const std::span<const uint32_t> point_of_corner_;
  core::Attribute<uint32_t> positions_;
  std::vector<int32_t> values_, position_values_;
  std::vector<uint32_t> rows_;
  std::vector<uint8_t> raw_;
};

}  // namespace

Expected<EncodedAttributes> encode_attributes(const AttributeSource& source, const StreamTraits& traits,
                                              const std::function<bool(size_t)>& texture_may_overflow,
                                              std::span<const core::Group<uint32_t>> groups,
                                              std::span<const uint32_t> point_of_corner) {
  EncodedAttributes out;
  out.plans = plan_attributes(*source.welded.mesh, source.codings, traits, texture_may_overflow);
  AttributeEncoder encoder(source, !traits.labels.empty(), groups, point_of_corner);
  if (Status status = encoder.encode(out); !status.ok()) return status;
  return out;
}

}  // namespace psplit
