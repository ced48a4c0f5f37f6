#include "encoder/coding/step_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace psplit {
namespace {

constexpr int kFloatBits = 24;

// The smallest grid with the step 2^exponent, or half of it, from the origins to the values `high`; nothing if
// it has more than kMostGridBits. These products are exact: libdraco takes the step as range / float(2^bits -
// 1), and the place as floor(offset * (float(2^bits - 1) / range) + 0.5).
// - Up to 23 bits, 2^bits - 1 is a float, and so is an odd place plus one half.
// - With 24 bits, a large odd place plus one half is no float. Half the step makes places even, at 25 bits.
// - From 25 bits on, float(2^bits - 1) is 2^bits.
std::optional<AttributeCoding> grid_of_step(std::vector<float> origin, const std::vector<float>& high,
                                            int exponent) {
  double extent = 0;
  for (size_t c = 0; c < origin.size(); ++c) extent = std::max(extent, double{high[c]} - double{origin[c]});
  const double places = std::ceil(std::ldexp(extent, -exponent));
  int bits = 1;
  while (bits <= kMostGridBits && std::ldexp(1.0, bits) - 1 < places) ++bits;
  if (bits > kMostGridBits) return std::nullopt;
  if (bits == kFloatBits) {
    ++bits;
    --exponent;
  }
  const double steps = std::ldexp(1.0, bits) - (bits < kFloatBits ? 1.0 : 0.0);
  const double range = std::ldexp(steps, exponent);
  // Libdraco divides by the step, which must be far from both ends of floats.
  constexpr int kMostExponent = 60;
  if (std::abs(exponent) > kMostExponent) return std::nullopt;
  return AttributeCoding{bits, false, std::move(origin), static_cast<float>(range)};
}

// The grid with a power of two as its step. Nothing if that takes more than 23 bits.
std::optional<AttributeCoding> with_power_of_two_step(const AttributeCoding& grid) {
  const int exponent = std::ilogb(grid_step(grid));
  std::vector<float> low, high;
  for (const float origin : grid.origin) {
    const double from = std::ldexp(std::floor(std::ldexp(double{origin}, -exponent)), exponent);
    low.push_back(static_cast<float>(from));
    if (double{low.back()} != from) return std::nullopt;
    high.push_back(std::nextafter(origin + grid.range, INFINITY));
  }
  std::optional<AttributeCoding> result = grid_of_step(std::move(low), high, exponent);
  return result && result->bits < kFloatBits && grid_extremes(*result) ? result : std::nullopt;
}

}  // namespace

std::optional<AttributeCoding> fit_whole_numbers(const CodingBounds& bounds) {
  if (bounds.low.empty() || bounds.common_power < 0) return std::nullopt;
  const int power = bounds.common_power == CodingBounds::kNoPower ? 0 : bounds.common_power;
  std::optional<AttributeCoding> grid = grid_of_step(bounds.low, bounds.high, power);
  // A larger extent has offsets that are no floats.
  if (!grid || double{grid->range} > std::ldexp(1.0, kFloatBits + power)) return std::nullopt;
  // Beyond 2^24 there may be no float that is the range above the least value, but one that is the range below
  // the largest.
  if (!grid_extremes(*grid)) {
    const double lower = double{bounds.high[0]} - double{grid->range};
    grid->origin[0] = static_cast<float>(lower);
    if (double{grid->origin[0]} != lower || !grid_extremes(*grid)) return std::nullopt;
  }
  grid->exact = true;
  return grid;
}

std::optional<AttributeCoding> fit_with_units(const CodingBounds& bounds, double step) {
  // Origins are multiples of the step, and of so large a power of two that 1 is a float above each.
  constexpr int kLeastUnit = -16;
  const int exponent = std::min(std::ilogb(step), 0);  // so that 1 and -1 are multiples
  std::vector<float> origin;
  for (const float low : bounds.low) {
    const int unit = std::max(exponent, kLeastUnit);
    origin.push_back(static_cast<float>(std::ldexp(std::floor(std::ldexp(double{low}, -unit)), unit)));
  }
  std::optional<AttributeCoding> grid = grid_of_step(std::move(origin), bounds.high, exponent);
  if (!grid || !grid_extremes(*grid)) return std::nullopt;
  const auto has = [&](float value) {
    const float from = grid->origin.back();
    const auto steps = static_cast<float>((int64_t{1} << grid->bits) - 1);
    return grid_place(value, from, grid->range, grid->bits) * (grid->range / steps) + from == value;
  };
  return has(bounds.low.back()) && has(bounds.high.back()) ? grid : std::nullopt;
}

bool fit_to_offsets(Span<AttributeCoding* const> grids, Span<const std::array<double, 3>> offsets) {
  if (grids.empty()) return true;
  const AttributeCoding& first = *grids.front();
  const bool is_one = std::ranges::all_of(grids, [&](const AttributeCoding* grid) {
    return !grid->exact && grid->bits == first.bits && grid->origin == first.origin &&
           grid->range == first.range;
  });
  const auto fitted = is_one ? with_power_of_two_step(first) : std::nullopt;
  if (!fitted) return false;
  const double step = grid_step(*fitted);
  for (const std::array<double, 3>& offset : offsets)
    for (const double along : offset)
      if (along / step != std::floor(along / step)) return false;
  for (AttributeCoding* grid : grids) *grid = *fitted;
  return true;
}

}  // namespace psplit
