#include "gltf_ext/document/meshopt_filters.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

namespace psplit {

std::vector<uint8_t> filter_to_multiples(std::span<const float> values, int exponent) {
  constexpr double kMost = 0x7fffff;
  std::vector<uint32_t> rows(values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    const double multiple = std::round(std::ldexp(double{values[i]}, -exponent));
    if (!(std::fabs(multiple) <= kMost)) return {};
    rows[i] = (static_cast<uint32_t>(exponent) << 24) |
              (static_cast<uint32_t>(static_cast<int32_t>(multiple)) & 0xffffff);
  }
  std::vector<uint8_t> bytes(rows.size() * sizeof(uint32_t));
  if (!bytes.empty()) std::memcpy(bytes.data(), rows.data(), bytes.size());  // little-endian, as glTF
  return bytes;
}

std::optional<int> exponent_for_bits(std::span<const float> values, int bits) {
  constexpr int kLeast = -100, kMost = 100;
  double largest = 0;
  for (const float value : values) largest = std::max(largest, std::fabs(double{value}));
  if (!(largest > 0) || !std::isfinite(largest)) return 0;
  int exponent = 0;
  std::frexp(largest, &exponent);
  exponent -= bits - 1;
  return exponent >= kLeast && exponent <= kMost ? std::optional(exponent) : std::nullopt;
}

std::vector<uint8_t> filter_rotations(std::span<const float> rotations, int bits) {
  const int one = (1 << (bits - 1)) - 1;
  std::vector<int16_t> rows;
  rows.reserve(rotations.size());
  for (size_t i = 0; i + 4 <= rotations.size(); i += 4) {
    const std::span<const float> rotation = rotations.subspan(i, 4);
    size_t largest = 0;
    for (size_t k = 1; k < 4; ++k)
      if (std::fabs(rotation[k]) > std::fabs(rotation[largest])) largest = k;
    const double scale = (rotation[largest] < 0 ? -1 : 1) * std::sqrt(2.0) * one;
    for (size_t k = 1; k < 4; ++k) {
      const double number = std::round(rotation[(largest + k) % 4] * scale);
      rows.push_back(static_cast<int16_t>(std::clamp<double>(number, -one, one)));
    }
    // The filter finds the number that stands for 1 here, and the largest component in its last bits.
    rows.push_back(static_cast<int16_t>((one & ~3) | static_cast<int>(largest)));
  }
  std::vector<uint8_t> bytes(rows.size() * sizeof(int16_t));
  if (!bytes.empty()) std::memcpy(bytes.data(), rows.data(), bytes.size());
  return bytes;
}

}  // namespace psplit
