// Hashes and noise whose bits are the same on every machine: they use integers, and floating-point operations
// that IEEE 754 rounds exactly.
#pragma once

#include <cmath>
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

// Value noise in [-1, 1) on the integer lattice, with a continuous first derivative.
inline double value_noise(Vec3 p, uint64_t seed) {
  const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
  const auto ix = static_cast<int64_t>(fx), iy = static_cast<int64_t>(fy), iz = static_cast<int64_t>(fz);
  const auto ease = [](double t) { return t * t * (3 - 2 * t); };
  const double tx = ease(p.x - fx), ty = ease(p.y - fy), tz = ease(p.z - fz);
  const auto along_x = [&](int64_t y, int64_t z) {
    const double a = signed_unit(hash_lattice(ix, y, z, seed));
    const double b = signed_unit(hash_lattice(ix + 1, y, z, seed));
    return a + (b - a) * tx;
  };
  const auto along_y = [&](int64_t z) {
    const double a = along_x(iy, z);
    return a + (along_x(iy + 1, z) - a) * ty;
  };
  const double a = along_y(iz);
  return a + (along_y(iz + 1) - a) * tz;
}

// Over three times the root mean square of the gradient of value_noise. On one axis, the gradient can reach 3
// (the easing's slope of 1.5, times a difference of 2), but several octaves are not that steep at the same
// place.
inline constexpr double kNoiseSlope = 1.4;

// Like a sine of period 1, but made of parabolas, without libm. In [-1, 1], with a slope of at most 8.
inline double parabola_wave(double x) {
  const double u = x - std::floor(x + 0.5);
  return 8 * u * (1 - 2 * std::fabs(u));
}

}  // namespace psplit
