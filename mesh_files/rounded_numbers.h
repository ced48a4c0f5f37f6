// Numbers of mesh files that become floats, because glTF has no other type for them.
#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <string>

#include "mesh_files/mesh_file.h"

namespace psplit {

// Whether a float is equal to the integer.
template <std::integral T>
bool has_float(T value) {
  constexpr uint64_t kFirstWithout = uint64_t{1} << std::numeric_limits<float>::digits;
  const uint64_t bits = static_cast<uint64_t>(value), magnitude = value < 0 ? 0 - bits : bits;
  return magnitude == 0 || magnitude >> std::countr_zero(magnitude) < kFirstWithout;
}

// Whether a double is equal to a float; infinities and NaN count as equal.
inline bool has_float(double value) {
  if (!std::isfinite(value)) return true;
  const bool fits = std::fabs(value) <= double{std::numeric_limits<float>::max()};
  return fits && double{static_cast<float>(value)} == value;
}

// `kind`: "whole number", for example.
inline void say_rounded(const std::string& kind, const std::string& semantic, uint64_t count, Losses& losses) {
  losses.add(kind + " of " + semantic + " is rounded: no float is equal to it",
             kind + "s of " + semantic + " are rounded: no floats are equal to them", count);
}

}  // namespace psplit
