#include "encoder/stream/attribute_plan.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "encoder/fields/entropy_encoder.h"
#include "src/container/bit_string.h"
#include "src/container/stored_type.h"

namespace psplit {
namespace {

using core::Coding, core::Scheme, core::Transform;

Coding coding_of(const DracoLabel& label, const AttributeCoding& coding) {
  if (label.type != DataType::kFloat32) return Coding::kInteger;
  if (coding.bits <= 0) return Coding::kRaw;
  return label.semantic == DracoSemantic::kNormal ? Coding::kNormal : Coding::kQuantized;
}

// Whether values are integers of which products can be made.
bool has_steps(const AttributePlan& plan) {
  return plan.description.coding == Coding::kInteger || plan.description.coding == Coding::kQuantized;
}

// The numbers are libdraco's choices by speed. `bits`: as requested, even for integers.
Scheme choose_scheme(const AttributePlan& plan, int bits, const AttributePlan& positions,
                     const StreamTraits& traits, const std::function<bool(size_t)>& texture_may_overflow) {
  constexpr int kFastest = 10, kByDifference = 8, kOneParallelogram = 2;
  constexpr uint32_t kFewPoints = 40;
  if (plan.description.coding == Coding::kRaw) return Scheme::kNone;
  // Without a corner table, whatever was chosen becomes a difference.
  if (traits.speed >= kFastest || traits.is_sequential) return Scheme::kDifference;
  const auto semantic = static_cast<DracoSemantic>(plan.description.semantic);
  const bool from_positions = traits.speed < kSpeedWithoutPositions;
  if (semantic == DracoSemantic::kTexCoord && plan.description.components == 2 && bits > 0 && from_positions) {
    if (texture_may_overflow(plan.source)) return Scheme::kParallelogram;
    if (has_steps(positions) && predicts_texture(positions.description.bits, bits)) return Scheme::kTexCoords;
  }
  if (semantic == DracoSemantic::kNormal)
    return from_positions && plan.description.coding == Coding::kNormal &&
                   positions.description.coding != Coding::kRaw
               ? Scheme::kGeometricNormal
               : Scheme::kDifference;
  if (traits.speed >= kByDifference) return Scheme::kDifference;
  return traits.speed >= kOneParallelogram || traits.point_count < kFewPoints
             ? Scheme::kParallelogram
             : Scheme::kConstrainedMultiParallelogram;
}

// Draco's descriptions of attributes whose caller does not give them.
DracoLabel label_of(const Attribute& attribute, const AttributeCoding& coding, bool is_cloud) {
  return {draco_semantic(attribute, coding, is_cloud), stored_type(attribute.component_type)};
}

std::vector<size_t> own_order(const Mesh& mesh) {
  std::vector<size_t> order(mesh.attributes.size());
  std::iota(order.begin(), order.end(), size_t{0});
  return order;
}

void append_float(float value, std::vector<uint8_t>& out) { append_u32(std::bit_cast<uint32_t>(value), out); }

}  // namespace

DracoSemantic draco_semantic(const Attribute& attribute, const AttributeCoding& coding, bool is_cloud) {
  const auto starts = [&](const char* prefix) { return attribute.semantic.starts_with(prefix); };
  if (attribute.semantic == "POSITION") return DracoSemantic::kPosition;
  if (attribute.semantic == "NORMAL" && (coding.octahedral || is_cloud)) return DracoSemantic::kNormal;
  if (starts("TEXCOORD_") && attribute.component_count == 2) return DracoSemantic::kTexCoord;
  if (starts("COLOR_")) return DracoSemantic::kColor;
  return DracoSemantic::kGeneric;
}

std::vector<size_t> attribute_order(const Mesh& mesh) {
  std::vector<size_t> order = own_order(mesh);
  std::stable_partition(order.begin(), order.end(),
                        [&](size_t i) { return mesh.attributes[i].semantic == "POSITION"; });
  return order;
}

std::vector<AttributePlan> plan_attributes(const Mesh& mesh, std::span<const size_t> seams_of,
                                           std::span<const AttributeCoding> codings, const StreamTraits& traits,
                                           const std::function<bool(size_t)>& texture_may_overflow) {
  std::vector<AttributePlan> plans;
  const bool has_labels = !traits.labels.empty(),
             has_groups = !traits.is_sequential && traits.speed < kSpeedOfOneTable;
  std::vector<uint32_t> group_of(mesh.attributes.size(), 0);
  uint32_t next_group = 1;
  for (const size_t i : has_labels ? own_order(mesh) : attribute_order(mesh)) {
    const Attribute& attribute = mesh.attributes[i];
    const DracoLabel label = has_labels ? traits.labels[i] : label_of(attribute, codings[i], traits.is_cloud);
    AttributePlan& plan = plans.emplace_back();
    plan.source = i;
    const bool has_own_seams = seams_of.empty() || seams_of[i] == i;
    if (has_groups && label.semantic != DracoSemantic::kPosition && has_own_seams) group_of[i] = next_group++;
    core::Attribute<uint32_t>& description = plan.description;
    description.semantic = static_cast<uint8_t>(label.semantic);
    description.type = label.type;
    description.components = attribute.component_count;
    description.normalized = attribute.normalized;
    description.unique_id = static_cast<uint32_t>(plans.size() - 1);
    description.coding = coding_of(label, codings[i]);
    if (description.coding == Coding::kQuantized || description.coding == Coding::kNormal)
      description.bits = static_cast<uint8_t>(codings[i].bits);
    if (description.coding == Coding::kQuantized) {
      description.range = codings[i].range;
      plan.origin = codings[i].origin;
    }
    if (description.coding == Coding::kNormal) plan.transform = Transform::kOctahedronCanonicalized;
  }
  for (AttributePlan& plan : plans) {
    const size_t i = plan.source;
    plan.group = group_of[seams_of.empty() ? i : seams_of[i]];
    plan.by_degree = plan.group == 0 && !traits.is_sequential && traits.speed == kSpeedByDegree;
  }
  // Where targets join the groups of others, these come together.
  if (!seams_of.empty() && !std::ranges::equal(seams_of, own_order(mesh))) {
    // A sort takes thousands of bytes of the web's module.
    std::vector<AttributePlan> sorted;
    for (uint32_t group = 0; group < next_group; ++group)
      for (AttributePlan& plan : plans)
        if (plan.group == group) sorted.push_back(std::move(plan));
    plans = std::move(sorted);
  }
  const auto is_position = [](const AttributePlan& plan) {
    return static_cast<DracoSemantic>(plan.description.semantic) == DracoSemantic::kPosition;
  };
  const auto positions = std::ranges::find_if(plans, is_position);
  for (AttributePlan& plan : plans)
    plan.scheme = choose_scheme(plan, codings[plan.source].bits, positions == plans.end() ? plan : *positions,
                                traits, texture_may_overflow);
  // Attributes that are predicted from positions further on in the order are moved after all others.
  if (positions != plans.end())
    if (const auto waiting = std::stable_partition(plans.begin(), positions,
                                                   [](const AttributePlan& plan) {
                                                     return plan.scheme != Scheme::kTexCoords &&
                                                            plan.scheme != Scheme::kGeometricNormal;
                                                   });
        waiting != positions)
      std::rotate(waiting, positions, plans.end());
  return plans;
}

void append_description(const AttributePlan& plan, std::vector<uint8_t>& out) {
  const core::Attribute<uint32_t>& description = plan.description;
  out.insert(out.end(), {description.semantic, static_cast<uint8_t>(description.type), description.components,
                         static_cast<uint8_t>(description.normalized)});
  append_varint(description.unique_id, out);
}

void append_scheme(const AttributePlan& plan, std::vector<uint8_t>& out) {
  if (plan.description.coding == Coding::kRaw) return;
  out.push_back(static_cast<uint8_t>(plan.scheme));
  if (plan.is_predicted()) out.push_back(static_cast<uint8_t>(plan.transform));
  constexpr uint8_t kEntropyCoded = 1;
  out.push_back(kEntropyCoded);
}

void append_prediction_grid(const AttributePlan& plan, std::vector<uint8_t>& out) {
  if (plan.description.coding != Coding::kNormal || !plan.is_predicted()) return;
  const core::OctahedralGrid grid(plan.description.bits);
  append_u32(grid.max_quantized(), out);
  append_u32(static_cast<uint32_t>(grid.center()), out);
}

void append_transform(const AttributePlan& plan, std::vector<uint8_t>& out) {
  const core::Attribute<uint32_t>& description = plan.description;
  if (description.coding == Coding::kQuantized) {
    for (const float origin : plan.origin) append_float(origin, out);
    append_float(description.range, out);
  }
  if (description.coding == Coding::kQuantized || description.coding == Coding::kNormal)
    out.push_back(description.bits);
}

std::vector<uint8_t> edgebreaker_skeleton(std::span<const AttributePlan> plans, bool is_valence,
                                          std::span<const uint8_t> has_seams) {
  // The version, a mesh, Edgebreaker, and flags of which none is set.
  std::vector<uint8_t> out = {'D', 'R', 'A', 'C', 'O', 2, 2, 1, 1, 0, 0};
  constexpr uint8_t kStandard = 0, kValence = 2, kDepthFirst = 0, kPredictionDegree = 1;
  out.push_back(is_valence ? kValence : kStandard);
  out.push_back(static_cast<uint8_t>(has_seams.size()));
  std::vector<std::span<const AttributePlan>> groups;
  for (size_t first = 0, end = 0; first < plans.size(); first = end) {
    while (end < plans.size() && plans[end].group == plans[first].group) ++end;
    groups.push_back(plans.subspan(first, end - first));
  }
  out.push_back(static_cast<uint8_t>(groups.size()));
  constexpr uint8_t kNoData = 0xff;
  for (const std::span<const AttributePlan> plans_of_group : groups) {
    const uint32_t group = plans_of_group[0].group;
    out.push_back(group == 0 ? kNoData : static_cast<uint8_t>(group - 1));
    out.push_back(group == 0 || has_seams[group - 1] == 0 ? 0 : 1);  // whether it has a table of its own
    out.push_back(plans_of_group[0].by_degree ? kPredictionDegree : kDepthFirst);
  }
  for (const std::span<const AttributePlan> plans_of_group : groups) {
    append_varint(plans_of_group.size(), out);
    for (const AttributePlan& plan : plans_of_group) append_description(plan, out);
    for (const AttributePlan& plan : plans_of_group)
      out.push_back(static_cast<uint8_t>(plan.description.coding));
  }
  for (const std::span<const AttributePlan> plans_of_group : groups) {
    for (const AttributePlan& plan : plans_of_group) {
      append_scheme(plan, out);
      append_prediction_grid(plan, out);
    }
    for (const AttributePlan& plan : plans_of_group) append_transform(plan, out);
  }
  return out;
}

}  // namespace psplit
