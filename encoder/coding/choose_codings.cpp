#include "encoder/coding/choose_codings.h"

#include <array>
#include <cmath>
#include <cstring>

#include "encoder/coding/quantization.h"

namespace psplit {
namespace {

bool all_unit_vectors(const Attribute& attribute) {
  for (size_t at = 0; at < attribute.values.size(); at += 12) {
    std::array<float, 3> v{};
    std::memcpy(v.data(), attribute.values.data() + at, 12);
    const double square =
        double{v[0]} * double{v[0]} + double{v[1]} * double{v[1]} + double{v[2]} * double{v[2]};
    if (!(std::fabs(std::sqrt(square) - 1.0) <= 1e-2)) return false;
  }
  return true;
}

bool names_features(const std::string& semantic) {
  return semantic.starts_with("_FEATURE_ID_") || semantic == "_BATCHID";
}

AttributeCoding choose_coding(const Attribute& attribute, const CodingOptions& options) {
  if (attribute.component_type != ComponentType::kFloat32) return {};
  const auto starts = [&](const char* prefix) { return attribute.semantic.starts_with(prefix); };
  if (attribute.semantic == "NORMAL" && attribute.component_count == 3) {
    if (options.normal_bits < 2 || !all_unit_vectors(attribute)) return {};
    return {options.normal_bits, true, {}, 0};
  }
  const int bits = attribute.semantic == "POSITION" ? options.position_bits
                   : starts("TEXCOORD_")            ? options.texcoord_bits
                   : starts("COLOR_")               ? options.color_bits
                                                    : options.generic_bits;
  if (bits == 0) return {};
  Expected<AttributeCoding> grid = fit_grid(attribute, bits);
  return grid.ok() ? std::move(*grid) : AttributeCoding{};
}

}  // namespace

std::vector<AttributeCoding> choose_codings(Mesh& mesh, const CodingOptions& options,
                                            const std::set<std::string>& exact) {
  std::vector<AttributeCoding> codings;
  for (Attribute& attribute : mesh.attributes) {
    AttributeCoding& coding = codings.emplace_back();
    if (options.lossless || names_features(attribute.semantic) || exact.contains(attribute.semantic)) continue;
    trim_noise(attribute);
    coding = choose_coding(attribute, options);
  }
  return codings;
}

}  // namespace psplit
