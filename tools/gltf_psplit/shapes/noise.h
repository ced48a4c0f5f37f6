// Hashes and noise whose bits are the same on every machine: they use integers, and floating-point operations
// that IEEE 754 rounds exactly.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "tools/gltf_psplit/shapes/vec3.h"

namespace psplit {

// A bijection on 64 bits. If one bit of the argument changes, about half of the result's bits change.
inline uint64_t scramble(uint64_t bits) {
  bits = (bits ^ (bits >> 31)) * 0xbf58476d1ce4e5b9u;
  bits = (bits ^ (bits >> 29)) * 0x94d049bb133111ebu;
  return bits ^ (bits >> 32);
}

inline uint64_t hash_lattice(int64_t x, int64_t y, int64_t z, uint64_t seed) {
  const uint64_t key = static_cast<uint64_t>(x) * 0x9e3779b97f4a7c15u +
                       static_cast<uint64_t>(y) * 0xc2b2ae3d27d4eb4fu +
                       static_cast<uint64_t>(z) * 0x165667b19e3779f9u;
  return scramble(key + seed * 0xd6e8feb86659fd93u + seed);
}

// Maps the low 21 bits to [-1, 1).
inline double signed_unit(uint64_t bits) {
  return static_cast<double>(static_cast<int64_t>(bits & 0x1fffff) - 0x100000) * (1.0 / 0x100000);
}

// The noise at the corners of one cell of the lattice. Points that are evaluated one after the other are mostly
// in the same cell, whose corners then need no hashing.
struct NoiseCell {
  bool is_filled = false;
  int64_t x = 0, y = 0, z = 0;
  uint64_t seed = 0;
  std::array<double, 4> low{}, rise{};  // for each edge along x: the value at its lower end, and the change

  void fill(int64_t new_x, int64_t new_y, int64_t new_z, uint64_t new_seed) {
    *this = {true, new_x, new_y, new_z, new_seed, {}, {}};
    for (size_t edge = 0; edge < 4; ++edge) {
      const int64_t edge_y = y + static_cast<int64_t>(edge & 1), edge_z = z + static_cast<int64_t>(edge >> 1);
      low[edge] = signed_unit(hash_lattice(x, edge_y, edge_z, seed));
      rise[edge] = signed_unit(hash_lattice(x + 1, edge_y, edge_z, seed)) - low[edge];
    }
  }
};

// Like std::floor, without a call of the C library. |value| < 2^62.
inline int64_t floor_to_integer(double value) {
  const auto truncated = static_cast<int64_t>(value);
  return truncated - (value < static_cast<double>(truncated) ? 1 : 0);
}

// Value noise in [-1, 1) on the integer lattice, with a continuous first derivative.
inline double value_noise(Vec3 p, uint64_t seed) {
  constexpr size_t kCells = 16;  // the octaves of a field have consecutive seeds, and so cells of their own
  thread_local std::array<NoiseCell, kCells> cells;
  NoiseCell& cell = cells[seed % kCells];
  const int64_t x = floor_to_integer(p.x), y = floor_to_integer(p.y), z = floor_to_integer(p.z);
  if (!cell.is_filled || cell.x != x || cell.y != y || cell.z != z || cell.seed != seed)
    cell.fill(x, y, z, seed);
  const auto ease = [](double t) { return t * t * (3 - 2 * t); };
  const double tx = ease(p.x - static_cast<double>(x));
  const double ty = ease(p.y - static_cast<double>(y));
  const double tz = ease(p.z - static_cast<double>(z));
  const auto along_x = [&](size_t edge) { return cell.low[edge] + cell.rise[edge] * tx; };
  const auto along_y = [&](size_t edge) {
    const double a = along_x(edge);
    return a + (along_x(edge + 1) - a) * ty;
  };
  const double a = along_y(0);
  return a + (along_y(2) - a) * tz;
}

// This is over three times the root mean square of the gradient of value_noise. On one axis, the gradient can
// reach 3 (the easing's slope of 1.5, times a difference of 2), but several octaves are not that steep at the
// same place.
inline constexpr double kNoiseSlope = 1.4;

// A wave like a sine of period 1, but made of parabolas, without libm. Its values are in [-1, 1], and its slope
// is at most 8.
inline double parabola_wave(double x) {
  const double u = x - std::floor(x + 0.5);
  return 8 * u * (1 - 2 * std::fabs(u));
}

}  // namespace psplit
