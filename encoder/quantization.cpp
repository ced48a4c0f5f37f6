// Quantization grids: encode_mesh.h says what they are.
#include "encoder/quantization.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace psplit {
namespace {

// Below this the reciprocal of a grid step is no longer a float, and libdraco divides by it.
float smallest_range(int bits) { return std::ldexp(1e-37f, bits); }

// Widens the range until grid_extremes finds it: a few steps of the float, if any.
void settle(AttributeCoding& coding) {
  for (int step = 0; step < 64 && !grid_extremes(coding); ++step) {
    // The component nearest to zero has the finest floats.
    const auto finest = std::min_element(coding.origin.begin(), coding.origin.end(),
                                         [](float a, float b) { return std::fabs(a) < std::fabs(b); });
    const float next = std::nextafter(*finest + coding.range, INFINITY) - *finest;
    coding.range = std::max(next, std::nextafter(coding.range, INFINITY));
  }
}

}  // namespace

std::optional<GridExtremes> grid_extremes(const AttributeCoding& coding) {
  for (size_t c = 0; c < coding.origin.size(); ++c) {
    const float sum = coding.origin[c] + coding.range;
    for (const float high : {sum, std::nextafter(sum, INFINITY), std::nextafter(sum, -INFINITY)}) {
      if (high - coding.origin[c] != coding.range) continue;
      GridExtremes extremes{coding.origin, coding.origin};
      extremes.high[c] = high;
      return extremes;
    }
  }
  return std::nullopt;
}

Expected<AttributeCoding> fit_grid(const Attribute& attribute, int bits) {
  if (attribute.component_type != ComponentType::kFloat32)
    return invalid_input(attribute.semantic + ": only floats are quantized");
  const size_t components = attribute.component_count;
  const size_t count = attribute.values.size() / sizeof(float);
  AttributeCoding coding;
  coding.bits = bits;
  coding.origin.assign(components, 0.0f);
  std::vector<float> high(components, 0.0f);
  for (size_t i = 0; i < count; ++i) {
    float value = 0;
    std::memcpy(&value, attribute.values.data() + i * sizeof(float), sizeof(float));
    if (!std::isfinite(value))
      return invalid_input(attribute.semantic + ": point " + std::to_string(i / components) + " is not finite");
    const size_t c = i % components;
    if (i < components) coding.origin[c] = high[c] = value;
    coding.origin[c] = std::min(coding.origin[c], value);
    high[c] = std::max(high[c], value);
  }
  coding.range = smallest_range(bits);
  for (size_t c = 0; c < components; ++c) coding.range = std::max(coding.range, high[c] - coding.origin[c]);
  settle(coding);
  if (!std::isfinite(coding.range)) return invalid_input(attribute.semantic + ": its extent is not a float");
  return coding;
}

AttributeCoding unit_grid(size_t component_count, int bits) {
  return {bits, false, std::vector<float>(component_count, 0.0f), 1.0f};
}

bool is_unit_grid(const AttributeCoding& coding) {
  return coding.bits > 0 && !coding.octahedral && coding.range == 1.0f &&
         std::all_of(coding.origin.begin(), coding.origin.end(), [](float origin) { return origin == 0; });
}

AttributeCoding merge_grids(const AttributeCoding& a, const AttributeCoding& b) {
  AttributeCoding merged = a;
  merged.range = 0;
  for (size_t c = 0; c < merged.origin.size(); ++c) {
    merged.origin[c] = std::min(a.origin[c], b.origin[c]);
    // An extent is at most the range, so this covers both, if not always with the smallest box.
    const float high = std::max(a.origin[c] + a.range, b.origin[c] + b.range);
    merged.range = std::max(merged.range, high - merged.origin[c]);
  }
  settle(merged);
  return merged;
}

}  // namespace psplit
