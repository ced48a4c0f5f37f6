#include "encoder/stream/encode_attributes.h"

#include "encoder/stream/attribute_corrections.h"
#include "encoder/stream/attribute_values.h"

namespace psplit {

Status AttributeEncoder::take_integers(const AttributePlan& plan, std::vector<int32_t>& values) {
  values.resize(rows_.size() * core::value_stride(attribute_.value_components()));
  attribute_.values = {values.data(), values.size()};
  return write_integers(mesh_attribute(plan), plan, rows_, values);
}

// A value is that of the point at which a walk meets it. Groups often share a walk.
void AttributeEncoder::find_points(const core::Group<uint32_t>& group) {
  const core::Sequence<uint32_t>& sequence = group.sequence;
  if (sequence.corner.data() == walk_) return;
  walk_ = sequence.corner.data();
  point_of_vertex_.resize(sequence.count);
  for (uint32_t i = 0; i < sequence.count; ++i)
    point_of_vertex_[group.table.table.vertex[sequence.corner[i]]] = point_of_corner_[sequence.corner[i]];
}

Status AttributeEncoder::take(AttributePlan& plan, const core::Group<uint32_t>& group) {
  const Attribute& from = mesh_attribute(plan);
  const bool is_raw = plan.description.coding == core::Coding::kRaw;
  if (plan.description.coding == core::Coding::kQuantized && !has_grids_) {
    rows_.resize(source_.points.size());
    for (uint32_t point = 0; point < rows_.size(); ++point) rows_[point] = row_of(plan, point);
    set_stream_grid(from, source_.codings[plan.source], rows_, plan);
  }
  attribute_ = plan.description;
  find_points(group);
  rows_.resize(group.sequence.count);
  for (uint32_t i = 0; i < rows_.size(); ++i) {
    const uint32_t vertex = is_raw ? group.table.table.vertex[group.sequence.corner[i]] : i;
    rows_[i] = row_of(plan, point_of_vertex_[vertex]);
  }
  const bool is_position = static_cast<DracoSemantic>(plan.description.semantic) == DracoSemantic::kPosition;
  if (is_raw) {
    raw_ = raw_values(from, rows_);
    attribute_.raw = raw_.data();
  } else if (Status status = take_integers(plan, is_position ? position_values_ : values_); !status.ok()) {
    return status;
  }
  // Other attributes are predicted from positions.
  if (is_position) positions_ = attribute_;
  return {};
}

Expected<AttributeFields> AttributeEncoder::correct(const AttributePlan& plan,
                                                    const core::Group<uint32_t>& group) const {
  Expected<AttributeFields> fields =
      correct_values({group, attribute_, plan.scheme, plan.transform, &groups_[0], &positions_});
  if (!fields) return unsupported(mesh_attribute(plan).semantic + ": " + fields.status().message());
  return fields;
}

Expected<EncodedAttributes> encode_attributes(const AttributeSource& source, const StreamTraits& traits,
                                              const std::function<bool(size_t)>& texture_may_overflow,
                                              std::span<const core::Group<uint32_t>> groups,
                                              std::span<const uint32_t> point_of_corner) {
  EncodedAttributes out;
  out.plans = plan_attributes(*source.welded.mesh, source.welded.seams_of, source.codings, traits,
                              texture_may_overflow);
  AttributeEncoder encoder(source, !traits.labels.empty(), groups, point_of_corner);
  for (AttributePlan& plan : out.plans) {
    if (Status status = encoder.take(plan, groups[plan.group]); !status.ok()) return status;
    Expected<AttributeFields> fields = encoder.correct(plan, groups[plan.group]);
    if (!fields) return fields.status();
    out.fields.push_back(std::move(*fields));
  }
  return out;
}

}  // namespace psplit
