#include "encoder/coding/quantization.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>

#include "encoder/coding/step_grid.h"
#include "src/mesh/number_of.h"

namespace psplit {
namespace {

// Below this the reciprocal of a grid step is no longer a float, and libdraco divides by it.
float smallest_range(int bits) { return std::ldexp(1e-37f, bits); }

constexpr int kMostWidenings = 64;

// Widens the range to the next for which grid_extremes may find values.
void widen(AttributeCoding& coding) {
  // The component nearest to zero has the finest floats.
  const auto finest = std::min_element(coding.origin.begin(), coding.origin.end(),
                                       [](float a, float b) { return std::fabs(a) < std::fabs(b); });
  const float next = std::nextafter(*finest + coding.range, INFINITY) - *finest;
  coding.range = std::max(next, std::nextafter(coding.range, INFINITY));
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
  while (grid_place(1, 0, 1, bits) * (1.0f / steps_of(bits)) != 1.0f) ++bits;
  return bits;
}

// Whether a grid of their extent has colours closer than the grid of the limits.
bool fits_closer(const Attribute& attribute, const Limits& limits, const CodingBounds& bounds, float extent,
                 int bits) {
  constexpr float kNoticed = 1.001f;
  return attribute.semantic.starts_with("COLOR_") && extent * kNoticed < limits.high - limits.low &&
         bounds.off_unit_grid > 0.5 * double{extent / steps_of(bits)};
}

// Moves the grid down in each component in which it would reach beyond the limit, so that its last place is the
// limit. A component of one value stays as it is, because its first place is this value. Widens the range until
// libdraco can have it, and until all values and no places beyond the limit are on the grid.
std::optional<AttributeCoding> fit_inside(const Limits& limits, const CodingBounds& bounds,
                                          AttributeCoding coding) {
  for (int step = 0; step < kMostWidenings; ++step, widen(coding)) {
    const float end =
        grid_place(coding.range, 0, coding.range, coding.bits) * (coding.range / steps_of(coding.bits));
    bool fits = true;
    for (size_t c = 0; c < coding.origin.size(); ++c) {
      const float low = bounds.low[c], high = bounds.high[c];
      coding.origin[c] = low;
      if (low == high) continue;
      if (low + coding.range > limits.high) coding.origin[c] = std::min(low, limits.high - end);
      fits = fits && coding.origin[c] >= limits.low && coding.origin[c] + end <= limits.high &&
             high - coding.origin[c] <= coding.range;
    }
    if (fits && grid_extremes(coding)) return coding;
  }
  return std::nullopt;
}

// Whether the last component, which is TANGENT.w, may be 1 or -1.
bool holds_units(const CodingBounds& bounds) {
  const auto is_unit = [](float value) { return std::fabs(value) == 1; };
  return !bounds.low.empty() && is_unit(bounds.low.back()) && is_unit(bounds.high.back());
}

bool is_unit_grid(const AttributeCoding& coding) {
  return coding.bits > 0 && !coding.octahedral && coding.range == 1 &&
         std::all_of(coding.origin.begin(), coding.origin.end(), [](float origin) { return origin == 0; });
}

void set_float(Attribute& attribute, size_t i, float value) {
  std::memcpy(attribute.values.data() + i * sizeof(float), &value, sizeof(float));
}

// CodingBounds::common_power of one value.
int power_of(float value) {
  constexpr int kMantissaBits = 23, kExponentBias = 127, kNoNumber = 255;
  if (value == 0) return CodingBounds::kNoPower;
  const auto bits = std::bit_cast<uint32_t>(value);
  const int exponent = static_cast<int>(bits >> kMantissaBits & 0xff);
  if (exponent == 0 || exponent == kNoNumber) return -1;
  const uint32_t mantissa = bits | 1u << kMantissaBits;
  return std::max(-1, exponent - kExponentBias - kMantissaBits + std::countr_zero(mantissa));
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

// A unit vector is scaled to |x| + |y| + |z| = 1 and rounded to a grid with c = 2^(bits-1) - 1 steps on each
// axis. The error is up to 1/2c in two components and 1/c in the third. If the rounded sum exceeds 1, one
// component has another 1/c. That is less than 1.7/c in all. Back on the sphere, lengths grow by at most
// sqrt(3).
double octahedral_bound(int bits) { return 3.0 / (std::ldexp(1.0, bits - 1) - 1.0) + 1e-6; }

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

void CodingBounds::add(const CodingBounds& other) {
  if (low.empty()) {
    low = other.low;
    high = other.high;
  }
  for (size_t c = 0; c < other.low.size(); ++c) {
    low[c] = std::min(low[c], other.low[c]);
    high[c] = std::max(high[c], other.high[c]);
  }
  is_finite = is_finite && other.is_finite;
  are_unit_vectors = are_unit_vectors && other.are_unit_vectors;
  off_unit_grid = std::max(off_unit_grid, other.off_unit_grid);
  common_power = std::min(common_power, other.common_power);
}

CodingBounds bounds_of(const Attribute& attribute, int bits, Span<const uint8_t> stored) {
  CodingBounds bounds;
  if (attribute.component_type != ComponentType::kFloat32) return bounds;
  const size_t components = attribute.component_count;
  const size_t count = attribute.values.size() / attribute.stride();
  const auto is_stored = [&](size_t i) { return stored.empty() || stored[i] != 0; };
  size_t first = 0;
  while (first < count && !is_stored(first)) ++first;
  if (first == count) return bounds;
  // Each loop has all that it changes in registers.
  for (size_t c = 0; c < components; ++c) {
    constexpr uint32_t kExponent = 0x7f800000;  // of NaN and infinity
    float low = float_at(attribute, first * components + c), high = low;
    bool is_finite = true;
    for (size_t i = first; i < count; ++i) {
      if (!is_stored(i)) continue;
      const float value = float_at(attribute, i * components + c);
      is_finite &= (std::bit_cast<uint32_t>(value) & kExponent) != kExponent;
      low = std::min(low, value);
      high = std::max(high, value);
    }
    bounds.low.push_back(low);
    bounds.high.push_back(high);
    bounds.is_finite &= is_finite;
  }
  for (size_t i = first; i < count && bounds.common_power >= 0; ++i)
    for (size_t c = 0; c < components && is_stored(i); ++c)
      bounds.common_power = std::min(bounds.common_power, power_of(float_at(attribute, i * components + c)));
  if (attribute.semantic.starts_with("COLOR_")) {
    const int unit_bits = bits_that_reach_the_end(bits);
    const float unit_step = 1.0f / steps_of(unit_bits);
    for (size_t i = first; i < count; ++i)
      for (size_t c = 0; c < components && is_stored(i); ++c) {
        const float value = float_at(attribute, i * components + c);
        const double off = std::fabs(double{grid_place(value, 0, 1, unit_bits) * unit_step} - double{value});
        bounds.off_unit_grid = std::max(bounds.off_unit_grid, off);
      }
  }
  if (attribute.semantic == "NORMAL")
    for (size_t i = first; i < count && bounds.are_unit_vectors; ++i) {
      if (!is_stored(i)) continue;
      double square = 0;
      for (size_t c = 0; c < components; ++c) {
        const double value{float_at(attribute, i * components + c)};
        square += value * value;
      }
      bounds.are_unit_vectors = is_unit_square(square);
    }
  return bounds;
}

Expected<AttributeCoding> fit_grid(const Attribute& attribute, const CodingBounds& bounds, int bits) {
  if (attribute.component_type != ComponentType::kFloat32)
    return invalid_input(attribute.semantic + ": only floats are quantized");
  if (!bounds.is_finite) return invalid_input(attribute.semantic + ": a value is not finite");
  AttributeCoding coding{bits, false, bounds.low, 0};
  if (bounds.low.empty()) coding.origin.assign(attribute.component_count, 0.0f);
  for (size_t c = 0; c < bounds.low.size(); ++c)
    coding.range = std::max(coding.range, bounds.high[c] - bounds.low[c]);
  if (!std::isfinite(coding.range)) return invalid_input(attribute.semantic + ": its extent is not a float");
  const auto limits = limits_of(attribute);
  const bool is_limited = limits &&
                          std::ranges::all_of(bounds.low, [&](float low) { return low >= limits->low; }) &&
                          std::ranges::all_of(bounds.high, [&](float high) { return high <= limits->high; });
  const bool is_closer = is_limited && fits_closer(attribute, *limits, bounds, coding.range, bits);
  coding.range = std::max(coding.range, smallest_range(bits));
  if (is_closer)
    if (const auto inside = fit_inside(*limits, bounds, coding)) return *inside;
  if (is_limited) {
    coding.bits = bits_that_reach_the_end(bits);
    coding.origin.assign(attribute.component_count, limits->low);
    coding.range = limits->high - limits->low;
    return coding;
  }
  if (attribute.semantic == "TANGENT" && holds_units(bounds))
    if (auto grid = fit_with_units(bounds, double{coding.range} / double{steps_of(bits)})) return *grid;
  for (int step = 0; step < kMostWidenings && !grid_extremes(coding); ++step) widen(coding);
  if (!std::isfinite(coding.range)) return invalid_input(attribute.semantic + ": its extent is not a float");
  return coding;
}

AttributeCoding grid_with_bits(AttributeCoding grid, int bits) {
  grid.bits = bits;
  if (grid.range >= smallest_range(bits)) return grid;
  grid.range = smallest_range(bits);
  for (int step = 0; step < kMostWidenings && !grid_extremes(grid); ++step) widen(grid);
  return grid;
}

Expected<AttributeCoding> fit_grid(const Attribute& attribute, int bits) {
  return fit_grid(attribute, bounds_of(attribute, bits), bits);
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

void round_weights(Mesh& mesh, Span<const AttributeCoding> codings) {
  struct Part {
    Attribute* attribute;
    size_t component;
  };
  std::vector<Part> parts;
  int bits = 0;
  for (size_t i = 0; i < codings.size(); ++i) {
    Attribute& attribute = mesh.attributes[i];
    if (!attribute.semantic.starts_with("WEIGHTS_") || !is_unit_grid(codings[i]) || codings[i].exact) continue;
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

std::vector<double> error_bounds(const AttributeCoding& coding) {
  if (coding.bits == 0) return {};
  if (coding.exact) return std::vector<double>(coding.octahedral ? 1 : coding.origin.size(), 0.0);
  if (coding.octahedral) return {octahedral_bound(coding.bits)};
  std::vector<double> bounds;
  for (const float origin : coding.origin) bounds.push_back(grid_bound(coding.bits, origin, coding.range));
  return bounds;
}

double direction_distance(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  if (a == b) return 0;
  const auto length = [](const std::array<double, 3>& v) {
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  };
  const double length_a = length(a), length_b = length(b);
  if (length_a == 0 || length_b == 0) return 0;
  double square = 0;
  for (size_t c = 0; c < 3; ++c) {
    const double apart = a[c] / length_a - b[c] / length_b;
    square += apart * apart;
  }
  return std::isnan(square) ? INFINITY : std::sqrt(square);
}

}  // namespace psplit
