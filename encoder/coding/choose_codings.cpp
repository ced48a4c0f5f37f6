#include "encoder/coding/choose_codings.h"

#include <algorithm>

#include "encoder/coding/step_grid.h"

namespace psplit {
namespace {

bool names_features(const std::string& semantic) {
  return semantic.starts_with("_FEATURE_ID_") || semantic == "_BATCHID";
}

bool is_direction(const Attribute& attribute) {
  return attribute.semantic == "NORMAL" && attribute.component_count == 3;
}

bool holds_whole_numbers(const CodingBounds& bounds) { return !bounds.low.empty() && bounds.common_power >= 0; }

// Whether glTF does not say what the numbers mean. Those to which it gives a meaning are geometry.
bool holds_data(const Attribute& attribute) {
  constexpr const char* kGeometry[] = {"POSITION", "NORMAL", "TANGENT", "TEXCOORD_", "COLOR_", "WEIGHTS_"};
  return attribute.component_type == ComponentType::kFloat32 && !target_of(attribute.semantic) &&
         !std::ranges::any_of(kGeometry,
                              [&](const char* prefix) { return attribute.semantic.starts_with(prefix); });
}

// The member for the kind of the attribute.
bool of_kind(const Attribute& attribute, const GivenBits& of) {
  const auto starts = [&](const char* prefix) { return attribute.semantic.starts_with(prefix); };
  if (is_direction(attribute)) return of.normal;
  return attribute.semantic == "POSITION" ? of.position
         : starts("TEXCOORD_")            ? of.texcoord
         : starts("COLOR_")               ? of.color
                                          : of.generic;
}

}  // namespace

void CodingOptions::give_changed_bits() {
  const CodingOptions usual;
  given.position |= position_bits != usual.position_bits;
  given.normal |= normal_bits != usual.normal_bits;
  given.texcoord |= texcoord_bits != usual.texcoord_bits;
  given.color |= color_bits != usual.color_bits;
  given.generic |= generic_bits != usual.generic_bits;
}

bool are_given(const Attribute& attribute, const CodingOptions& options) {
  return of_kind(attribute, options.given);
}

int wanted_bits(const Attribute& attribute, const CodingOptions& options) {
  if (attribute.component_type != ComponentType::kFloat32 || options.lossless ||
      names_features(attribute.semantic) || target_of(attribute.semantic) ||
      options.exact.contains(attribute.semantic))
    return 0;
  const auto starts = [&](const char* prefix) { return attribute.semantic.starts_with(prefix); };
  if (is_direction(attribute)) return options.normal_bits < 2 ? 0 : options.normal_bits;
  return attribute.semantic == "POSITION" ? options.position_bits
         : starts("TEXCOORD_")            ? options.texcoord_bits
         : starts("COLOR_")               ? options.color_bits
                                          : options.generic_bits;
}

CodingBounds wanted_bounds(const Attribute& attribute, const CodingOptions& options,
                           Span<const uint8_t> stored) {
  const int bits = wanted_bits(attribute, options);
  return bits == 0 && (options.lossless || !holds_data(attribute)) ? CodingBounds()
                                                                   : bounds_of(attribute, bits, stored);
}

AttributeCoding choose_coding(const Attribute& attribute, const CodingBounds& bounds,
                              const CodingOptions& options) {
  const int bits = wanted_bits(attribute, options);
  if (holds_data(attribute) && !options.lossless && holds_whole_numbers(bounds)) {
    const auto grid = fit_whole_numbers(bounds);
    const bool may_round = bits > 0 && are_given(attribute, options);
    if (grid && (!may_round || grid->bits <= bits)) return *grid;
    if (!may_round) return {};
  }
  if (bits == 0) return {};
  if (is_direction(attribute))
    return bounds.are_unit_vectors ? AttributeCoding{bits, true, {}, 0} : AttributeCoding{};
  Expected<AttributeCoding> grid = fit_grid(attribute, bounds, bits);
  return grid.ok() ? std::move(*grid) : AttributeCoding{};
}

AttributeCoding choose_coding(Attribute& attribute, const CodingOptions& options) {
  if (wanted_bits(attribute, options) > 0) trim_noise(attribute);
  return choose_coding(attribute, wanted_bounds(attribute, options), options);
}

std::string loss_of_whole_numbers(const Attribute& attribute, const CodingBounds& bounds,
                                  const AttributeCoding& coding) {
  if (!holds_data(attribute) || !holds_whole_numbers(bounds) || coding.bits == 0 || coding.exact) return "";
  const auto grid = fit_whole_numbers(bounds);
  return attribute.semantic + ": its whole numbers are rounded to a grid of " + std::to_string(coding.bits) +
         " bits; " +
         (grid ? std::to_string(grid->bits) + " bits would keep them" : "only --lossless would keep them");
}

}  // namespace psplit
