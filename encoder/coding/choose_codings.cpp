#include "encoder/coding/choose_codings.h"

#include "encoder/coding/precision_guard.h"

namespace psplit {
namespace {

bool names_features(const std::string& semantic) {
  return semantic.starts_with("_FEATURE_ID_") || semantic == "_BATCHID";
}

bool is_direction(const Attribute& attribute) {
  return attribute.semantic == "NORMAL" && attribute.component_count == 3;
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

int wanted_bits(const Attribute& attribute, const CodingOptions& options, const std::set<std::string>& exact) {
  if (attribute.component_type != ComponentType::kFloat32 || options.lossless ||
      names_features(attribute.semantic) || exact.contains(attribute.semantic))
    return 0;
  const auto starts = [&](const char* prefix) { return attribute.semantic.starts_with(prefix); };
  if (is_direction(attribute)) return options.normal_bits < 2 ? 0 : options.normal_bits;
  return attribute.semantic == "POSITION" ? options.position_bits
         : starts("TEXCOORD_")            ? options.texcoord_bits
         : starts("COLOR_")               ? options.color_bits
                                          : options.generic_bits;
}

AttributeCoding choose_coding(const Attribute& attribute, const CodingBounds& bounds, int bits) {
  if (bits == 0) return {};
  if (is_direction(attribute))
    return bounds.are_unit_vectors ? AttributeCoding{bits, true, {}, 0} : AttributeCoding{};
  Expected<AttributeCoding> grid = fit_grid(attribute, bounds, bits);
  return grid.ok() ? std::move(*grid) : AttributeCoding{};
}

AttributeCoding choose_coding(Attribute& attribute, const CodingOptions& options,
                              const std::set<std::string>& exact) {
  const int bits = wanted_bits(attribute, options, exact);
  if (bits > 0) trim_noise(attribute);
  return choose_coding(attribute, bits == 0 ? CodingBounds() : bounds_of(attribute, bits), bits);
}

std::vector<AttributeCoding> choose_codings(Mesh& mesh, const CodingOptions& options,
                                            const std::set<std::string>& exact) {
  std::vector<AttributeCoding> codings;
  for (Attribute& attribute : mesh.attributes) codings.push_back(choose_coding(attribute, options, exact));
  guard_codings(mesh, options, exact, codings);
  return codings;
}

}  // namespace psplit
