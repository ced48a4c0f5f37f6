#include "encoder/coding/quantization.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace psplit {
namespace {

// Below this the reciprocal of a grid step is no longer a float, and libdraco divides by it.
float smallest_range(int bits) { return std::ldexp(1e-37f, bits); }

// Widens the range until grid_extremes finds values. That takes a few float steps at most.
void settle(AttributeCoding& coding) {
  for (int step = 0; step < 64 && !grid_extremes(coding); ++step) {
    // The component nearest to zero has the finest floats.
    const auto finest = std::min_element(coding.origin.begin(), coding.origin.end(),
                                         [](float a, float b) { return std::fabs(a) < std::fabs(b); });
    const float next = std::nextafter(*finest + coding.range, INFINITY) - *finest;
    coding.range = std::max(next, std::nextafter(coding.range, INFINITY));
  }
}

// The limits that glTF sets for the values of an attribute. A grid that ends at both decodes to no value
// outside.
struct Limits {
  float low, high;
};
std::optional<Limits> limits_of(const Attribute& attribute) {
  const auto starts = [&](const char* prefix) { return attribute.semantic.starts_with(prefix); };
  if (starts("COLOR_") || starts("WEIGHTS_")) return Limits{0, 1};
  if (attribute.semantic == "TANGENT") return Limits{-1, 1};
  return std::nullopt;
}

float steps_of(int bits) { return static_cast<float>((int64_t{1} << bits) - 1); }

// TANGENT.w is at one of its limits. But the last multiple of a rounded step may miss the limit (at 5 bits).
int bits_that_reach_the_end(int bits) {
  while (steps_of(bits) * (1.0f / steps_of(bits)) != 1.0f) ++bits;
  return bits;
}

bool is_unit_grid(const AttributeCoding& coding) {
  return coding.bits > 0 && !coding.octahedral && coding.range == 1 &&
         std::all_of(coding.origin.begin(), coding.origin.end(), [](float origin) { return origin == 0; });
}

float float_at(const Attribute& attribute, size_t i) {
  float value = 0;
  std::memcpy(&value, attribute.values.data() + i * sizeof(float), sizeof(float));
  return value;
}
void set_float(Attribute& attribute, size_t i, float value) {
  std::memcpy(attribute.values.data() + i * sizeof(float), &value, sizeof(float));
}

// Rounds weights to whole steps with the same sum: the largest remainders are rounded up. A sum near one, as
// other quantizers leave it (8 bits: up to 2 / 255 off), becomes one.
void round_together(std::span<double> weights, double steps) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  const double target = std::fabs(sum - steps) <= steps / 100 ? steps : std::round(sum);
  if (target == 0) {
    std::fill(weights.begin(), weights.end(), 0.0);
    return;
  }
  std::vector<double> remainder;
  double left = target;
  for (double& weight : weights) {
    const double exact = weight * (target / sum);
    weight = std::floor(exact);
    remainder.push_back(exact - weight);
    left -= weight;
  }
  for (; left > 0; --left) {
    const auto largest = std::max_element(remainder.begin(), remainder.end());
    weights[static_cast<size_t>(largest - remainder.begin())] += 1;
    *largest = 0;
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
    const float value = float_at(attribute, i);
    if (!std::isfinite(value))
      return invalid_input(attribute.semantic + ": point " + std::to_string(i / components) + " is not finite");
    const size_t c = i % components;
    if (i < components) coding.origin[c] = high[c] = value;
    coding.origin[c] = std::min(coding.origin[c], value);
    high[c] = std::max(high[c], value);
  }
  if (const auto limits = limits_of(attribute);
      limits && *std::min_element(coding.origin.begin(), coding.origin.end()) >= limits->low &&
      *std::max_element(high.begin(), high.end()) <= limits->high) {
    coding.bits = bits_that_reach_the_end(bits);
    coding.origin.assign(components, limits->low);
    coding.range = limits->high - limits->low;
    return coding;
  }
  coding.range = smallest_range(bits);
  for (size_t c = 0; c < components; ++c) coding.range = std::max(coding.range, high[c] - coding.origin[c]);
  settle(coding);
  if (!std::isfinite(coding.range)) return invalid_input(attribute.semantic + ": its extent is not a float");
  return coding;
}

AttributeCoding merge_grids(const AttributeCoding& a, const AttributeCoding& b) {
  AttributeCoding merged = a;
  merged.range = 0;
  for (size_t c = 0; c < merged.origin.size(); ++c) {
    merged.origin[c] = std::min(a.origin[c], b.origin[c]);
    // An extent is at most the range, so this covers both grids, though not always with the smallest box.
    const float high = std::max(a.origin[c] + a.range, b.origin[c] + b.range);
    merged.range = std::max(merged.range, high - merged.origin[c]);
  }
  settle(merged);
  return merged;
}

void trim_noise(Attribute& attribute) {
  constexpr float kNoise = 1e-5f;
  const auto limits = limits_of(attribute);
  if (!limits || attribute.component_type != ComponentType::kFloat32) return;
  for (size_t i = 0; i < attribute.values.size() / sizeof(float); ++i) {
    const float value = float_at(attribute, i);
    const float inside = std::clamp(value, limits->low, limits->high);
    if (value != inside && std::fabs(value - inside) <= kNoise) set_float(attribute, i, inside);
  }
}

void round_weights(Mesh& mesh, std::span<const AttributeCoding> codings) {
  struct Part {
    Attribute* attribute;
    size_t component;
  };
  std::vector<Part> parts;
  int bits = 0;
  for (size_t i = 0; i < codings.size(); ++i) {
    Attribute& attribute = mesh.attributes[i];
    if (!attribute.semantic.starts_with("WEIGHTS_") || !is_unit_grid(codings[i])) continue;
    bits = codings[i].bits;
    for (size_t c = 0; c < attribute.component_count; ++c) parts.push_back({&attribute, c});
  }
  if (parts.empty()) return;
  const float steps = steps_of(bits), step = 1.0f / steps;
  std::vector<double> weights(parts.size());
  for (size_t point = 0; point < mesh.point_count; ++point) {
    const auto index = [&](const Part& part) {
      return point * part.attribute->component_count + part.component;
    };
    for (size_t k = 0; k < parts.size(); ++k)
      weights[k] = double{float_at(*parts[k].attribute, index(parts[k]))} * double{steps};
    round_together(weights, double{steps});
    for (size_t k = 0; k < parts.size(); ++k)
      set_float(*parts[k].attribute, index(parts[k]), static_cast<float>(weights[k]) * step);
  }
}

double grid_step(const AttributeCoding& grid) {
  return double{grid.range} / (std::ldexp(1.0, grid.bits) - 1.0);
}

// Half a step, and the rounding of libdraco's floats, each by at most u = 2^-24 of its result. Relative to the
// range: the offset from the origin, the reciprocal of the step, their product, the sum with one half, the
// step, the number of steps and its product with the step. Relative to the largest coordinate, which is at most
// |origin| + range: the last sum.
double grid_bound(int bits, float origin, float range) {
  const double step = double{range} / (std::ldexp(1.0, bits) - 1.0);
  return 0.5 * step + std::ldexp(8 * double{range} + std::fabs(double{origin}), -24);
}

// A unit vector is scaled to |x| + |y| + |z| = 1 and rounded to a grid with c = 2^(bits-1) - 1 steps on each
// axis. The error is up to 1/2c in two components and 1/c in the third. If the rounded sum exceeds 1, one
// component has another 1/c. That is less than 1.7/c in all. Back on the sphere, lengths grow by at most
// sqrt(3).
double octahedral_bound(int bits) { return 3.0 / (std::ldexp(1.0, bits - 1) - 1.0) + 1e-6; }

}  // namespace psplit
