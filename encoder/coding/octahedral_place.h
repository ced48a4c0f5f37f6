// Directions on an octahedral grid.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "src/core/octahedral.h"

namespace psplit {

// A direction as a place on an octahedral grid, as libdraco rounds it. All numbers are doubles except the
// components of the direction: a product with the reciprocal of the sum, not a quotient; a half is added before
// a number is rounded down. A vector that is too short, or infinite, is taken as (1, 0, 0).
inline core::Vec2 octahedral_place(const core::OctahedralGrid& grid, const float (&direction)[3]) {
  constexpr double kLeast = 1e-6;
  const double length =
      std::fabs(double{direction[0]}) + std::fabs(double{direction[1]}) + std::fabs(double{direction[2]});
  double scaled[3] = {1, 0, 0};
  if (length > kLeast && std::isfinite(length)) {
    const double scale = 1.0 / length;
    for (int k = 0; k < 3; ++k) scaled[k] = double{direction[k]} * scale;
  }
  const auto center = static_cast<double>(grid.center());
  const auto whole = [&](double number) { return static_cast<int32_t>(std::floor(number * center + 0.5)); };
  const int32_t x = whole(scaled[0]);
  int32_t y = whole(scaled[1]), z = grid.center() - std::abs(x) - std::abs(y);
  if (z < 0) {  // both were rounded up
    y += y > 0 ? z : -z;
    z = 0;
  }
  return grid.place_of(x, y, scaled[2] < 0 ? -z : z);
}

}  // namespace psplit
