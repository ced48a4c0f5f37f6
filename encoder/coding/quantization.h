// Quantization grids that libdraco reproduces to the bit.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <vector>

#include "psplit/base.h"
#include "psplit/encode.h"
#include "psplit/mesh.h"

namespace psplit {

// What a coding is fitted to. Meshes that share a grid join their bounds first: a cube around two cubes would
// be larger than the cube of all values.
struct CodingBounds {
  std::vector<float> low, high;  // of each component; empty without values
  bool is_finite = true;
  bool are_unit_vectors = true;  // of NORMAL
  // How far values are from the nearest place of the grid from 0 to 1, if glTF limits them to that.
  double off_unit_grid = 0;
  // Every value is a multiple of two to this power. kNoPower if all are 0; -1 if one is not a whole number.
  static constexpr int kNoPower = 128;
  int common_power = kNoPower;

  void add(const CodingBounds& other);
};
// The bounds of the points whose flag in `stored` is set, or of all points without flags. The bounds of an
// attribute that does not hold floats are empty.
CodingBounds bounds_of(const Attribute& attribute, int bits, Span<const uint8_t> stored = {});

// Whether a normal of this squared length can be stored as a direction.
inline bool is_unit_square(double square) { return std::fabs(std::sqrt(square) - 1.0) <= 1e-2; }

// The smallest grid that holds these values of the attribute: a step exceeds that of the largest extent by no
// more than floats force. But weights and tangents within glTF's limits get the limits' grid. So do colours, if
// their extent is within a thousandth of the limits', or if that grid has all of them as exactly as their own
// would. No decoded value of these is beyond the limits. Errors: kInvalidInput for NaN and infinity, or if the
// extent is not a float.
Expected<AttributeCoding> fit_grid(const Attribute& attribute, const CodingBounds& bounds, int bits);
// The grid of all values of the attribute.
Expected<AttributeCoding> fit_grid(const Attribute& attribute, int bits);

// A grid with the same places at its ends, or as near as libdraco can have them, and other bits.
AttributeCoding grid_with_bits(AttributeCoding grid, int bits);

// Values whose bounding box is the grid's. libdraco takes origin and range from the extremes of an attribute's
// values, and computes the range as the largest (maximum - minimum). Returns nothing if no float gives exactly
// the range. (libdraco's explicit quantization cannot be used: it passes numbers as text with six decimals.)
struct GridExtremes {
  std::vector<float> low, high;
};
std::optional<GridExtremes> grid_extremes(const AttributeCoding& coding);

// Sets values that exceed glTF's limits by no more than rounding noise to the limits. Then fit_grid's grid ends
// there too, and no decoded value is outside.
void trim_noise(Attribute& attribute);

// Rounds quantized weights to their grid so that the weights of a point, over all WEIGHTS_n, keep their sum.
// glTF wants the sum to be one; a sum that is nearly one becomes one.
void round_weights(Mesh& mesh, Span<const AttributeCoding> codings);

// The place of a value on a grid of 2^bits numbers, in libdraco's float arithmetic: a whole number. The range
// is above 0.
inline float grid_place(float value, float origin, float range, int bits) {
  return std::floor((value - origin) * (static_cast<float>((1u << bits) - 1) / range) + 0.5f);
}

// The distance of two neighbours on a grid that is not octahedral.
double grid_step(const AttributeCoding& grid);

// How far decoded values may be from the input in one component on a grid.
double grid_bound(int bits, float origin, float range);
// The bound of each component; or of the direction as a whole on an octahedral grid, as the chord between unit
// vectors. Empty for exact values.
std::vector<double> error_bounds(const AttributeCoding& coding);

// The distances that these bounds limit. Infinite if one value is NaN and the other is not the same NaN. Zeros
// of both signs are equal.
inline double component_distance(double a, double b) {
  if (a == b || std::memcmp(&a, &b, sizeof a) == 0) return 0;
  const double distance = std::fabs(a - b);
  return std::isnan(distance) ? INFINITY : distance;
}
// The chord between the directions of two vectors of any length. 0 if one has the length 0: it has no
// direction, so that every direction is right.
double direction_distance(const std::array<double, 3>& a, const std::array<double, 3>& b);
// The largest of them for a value whose components are a(c) and b(c). If it is a direction, that is its first
// three components together.
template <typename ComponentOfA, typename ComponentOfB>
double value_distance(size_t component_count, bool is_direction, ComponentOfA a, ComponentOfB b) {
  double largest = is_direction ? direction_distance({a(0), a(1), a(2)}, {b(0), b(1), b(2)}) : 0;
  for (size_t c = is_direction ? 3 : 0; c < component_count; ++c)
    largest = std::max(largest, component_distance(a(c), b(c)));
  return largest;
}

}  // namespace psplit
