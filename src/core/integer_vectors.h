// Integers and short vectors of them, for arithmetic that gives the same result everywhere. Sums of hostile
// input may leave the range: then they wrap around.
#pragma once

#include "src/core/platform.h"

namespace psplit::core {

struct Vec2 {
  int32_t s = 0, t = 0;
};
struct Vec3 {
  int64_t x = 0, y = 0, z = 0;
};

PSPLIT_HD constexpr int32_t wrapping_add(int32_t a, int32_t b) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) + static_cast<uint32_t>(b));
}
PSPLIT_HD constexpr int32_t wrapping_sub(int32_t a, int32_t b) {
  return static_cast<int32_t>(static_cast<uint32_t>(a) - static_cast<uint32_t>(b));
}
PSPLIT_HD constexpr uint32_t magnitude(int32_t a) {
  return a < 0 ? 0u - static_cast<uint32_t>(a) : static_cast<uint32_t>(a);
}
PSPLIT_HD constexpr uint64_t magnitude(int64_t a) {
  return a < 0 ? 0u - static_cast<uint64_t>(a) : static_cast<uint64_t>(a);
}
PSPLIT_HD constexpr uint64_t product(int64_t a, int64_t b) {
  return static_cast<uint64_t>(a) * static_cast<uint64_t>(b);
}

PSPLIT_HD constexpr int64_t wrapping_add(int64_t a, int64_t b) {
  return static_cast<int64_t>(static_cast<uint64_t>(a) + static_cast<uint64_t>(b));
}
PSPLIT_HD constexpr int64_t wrapping_sub(int64_t a, int64_t b) {
  return static_cast<int64_t>(static_cast<uint64_t>(a) - static_cast<uint64_t>(b));
}

PSPLIT_HD constexpr Vec3 plus(Vec3 a, Vec3 b) {
  return {wrapping_add(a.x, b.x), wrapping_add(a.y, b.y), wrapping_add(a.z, b.z)};
}
PSPLIT_HD constexpr Vec3 minus(Vec3 a, Vec3 b) {
  return {wrapping_sub(a.x, b.x), wrapping_sub(a.y, b.y), wrapping_sub(a.z, b.z)};
}
PSPLIT_HD constexpr uint64_t dot(Vec3 a, Vec3 b) {
  return product(a.x, b.x) + product(a.y, b.y) + product(a.z, b.z);
}
// Adds the cross product of a and b to `sum`.
PSPLIT_HD constexpr void add_cross(Vec3& sum, Vec3 a, Vec3 b) {
  sum = plus(sum, {static_cast<int64_t>(product(a.y, b.z) - product(a.z, b.y)),
                   static_cast<int64_t>(product(a.z, b.x) - product(a.x, b.z)),
                   static_cast<int64_t>(product(a.x, b.y) - product(a.y, b.x))});
}

// floor(sqrt(x)), exactly.
PSPLIT_HD inline uint64_t integer_sqrt(uint64_t x) {
  auto root = static_cast<uint64_t>(square_root(static_cast<double>(x)));
  if (root > 0xffffffffu) root = 0xffffffffu;
  while (root * root > x) --root;
  while (root < 0xffffffffu && (root + 1) * (root + 1) <= x) ++root;
  return root;
}

}  // namespace psplit::core
