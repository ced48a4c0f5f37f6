#include "gltf_ext/document/meshopt_filters.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <type_traits>

namespace psplit {
namespace {

constexpr int8_t kLeastExponent = -100, kMostExponent = 100;  // of EXPONENTIAL

// The two filters that round square roots. meshoptimizer estimates their reciprocals, with other results on
// other processors; these are the extension's own formulas, whose results are the same everywhere.
template <typename T>
void unfilter_directions(uint8_t* rows, size_t count) {
  for (size_t i = 0; i < count; ++i, rows += 4 * sizeof(T)) {
    T row[4];
    std::memcpy(row, rows, sizeof row);
    // In units of the row's third number, so that all are integers.
    double x = row[0], y = row[1];
    const double z = row[2] - std::fabs(x) - std::fabs(y), below = std::min(z, 0.0);
    x -= std::copysign(below, x);
    y -= std::copysign(below, y);
    const double length = std::sqrt(x * x + y * y + z * z), scale = std::numeric_limits<T>::max();
    const auto rounded = [&](double value) {
      return static_cast<T>(length > 0 ? std::lround(value / length * scale) : 0);
    };
    row[0] = rounded(x), row[1] = rounded(y), row[2] = rounded(z);
    std::memcpy(rows, row, sizeof row);
  }
}

int16_t to_int16(double value) {
  return static_cast<int16_t>(std::clamp(std::lround(value), -0x8000L, 0x7fffL));
}

void unfilter_rotations(uint8_t* rows, size_t count) {
  for (size_t i = 0; i < count; ++i, rows += 4 * sizeof(int16_t)) {
    int16_t row[4];
    std::memcpy(row, rows, sizeof row);
    const int largest = row[3] & 3, one = row[3] | 3;
    const double scale = 32767 * std::sqrt(0.5) / one;
    const double x = row[0], y = row[1], z = row[2];
    const double left = 1 - (x * x + y * y + z * z) / (2.0 * one * one);
    int16_t rotation[4];
    for (int k = 0; k < 3; ++k) rotation[(largest + 1 + k) % 4] = to_int16(row[k] * scale);
    rotation[largest] = to_int16(32767 * std::sqrt(std::max(left, 0.0)));
    std::memcpy(rows, rotation, sizeof rotation);
  }
}

// Powers of two outside of the filter's range become those at its ends.
void unfilter_multiples(uint8_t* rows, size_t bytes) {
  for (size_t at = 0; at + sizeof(uint32_t) <= bytes; at += sizeof(uint32_t)) {
    uint32_t row = 0;
    std::memcpy(&row, rows + at, sizeof row);
    const int exponent = std::clamp(static_cast<int8_t>(row >> 24), kLeastExponent, kMostExponent);
    const int32_t multiple = static_cast<int32_t>(row << 8) >> 8;
    const auto value = static_cast<float>(multiple) * std::bit_cast<float>((exponent + 127) << 23);
    std::memcpy(rows + at, &value, sizeof value);
  }
}

// The last number of a row is alpha in one bit less than the others have, below a 1.
template <typename T>
void unfilter_colors(uint8_t* rows, size_t count) {
  constexpr int kMost = std::numeric_limits<T>::max();
  for (size_t i = 0; i < count; ++i, rows += 4 * sizeof(T)) {
    T row[4];
    std::memcpy(row, rows, sizeof row);
    const int luma = row[0], alpha = row[3];
    const int orange = static_cast<std::make_signed_t<T>>(row[1]),
              green = static_cast<std::make_signed_t<T>>(row[2]);
    const int most = (1 << std::bit_width(row[3])) - 1, below = alpha & most >> 1;
    const auto scaled = [&](int value) {
      return static_cast<T>(
          most == 0 ? 0 : std::lround(static_cast<double>(std::clamp(value, 0, most)) * kMost / most));
    };
    row[0] = scaled(luma + orange - green), row[1] = scaled(luma + green),
    row[2] = scaled(luma - orange - green);
    row[3] = scaled(below << 1 | (below & 1));
    std::memcpy(rows, row, sizeof row);
  }
}

}  // namespace

void undo_meshopt_filter(const MeshoptRecord& view, uint8_t* rows) {
  if (view.filter == "OCTAHEDRAL" && view.stride == 4) unfilter_directions<int8_t>(rows, view.count);
  if (view.filter == "OCTAHEDRAL" && view.stride == 8) unfilter_directions<int16_t>(rows, view.count);
  if (view.filter == "QUATERNION") unfilter_rotations(rows, view.count);
  if (view.filter == "EXPONENTIAL") unfilter_multiples(rows, view.decoded_bytes());
  if (view.filter == "COLOR" && view.stride == 4) unfilter_colors<uint8_t>(rows, view.count);
  if (view.filter == "COLOR" && view.stride == 8) unfilter_colors<uint16_t>(rows, view.count);
}

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

std::vector<uint8_t> lift_multiples(std::span<const uint8_t> rows) {
  std::vector<uint32_t> numbers(rows.size() / sizeof(uint32_t));
  if (!numbers.empty()) std::memcpy(numbers.data(), rows.data(), numbers.size() * sizeof(uint32_t));
  int bits = 1, least = kMostExponent;
  for (const uint32_t number : numbers) {
    const int32_t multiple = static_cast<int32_t>(number << 8) >> 8;
    bits =
        std::max(bits, 1 + static_cast<int>(std::bit_width(static_cast<uint32_t>(multiple ^ multiple >> 31))));
    least = std::min<int>(least, static_cast<int8_t>(number >> 24));
  }
  const int shift = (24 - bits) / 8 * 8;
  if (least - shift < kLeastExponent) return {rows.begin(), rows.end()};
  for (uint32_t& number : numbers)
    number = ((number << shift) & 0xffffff) | ((number >> 24) - static_cast<uint32_t>(shift)) << 24;
  std::vector<uint8_t> lifted(rows.size());
  if (!numbers.empty()) std::memcpy(lifted.data(), numbers.data(), lifted.size());
  return lifted;
}

std::optional<int> exponent_for_bits(std::span<const float> values, int bits) {
  double largest = 0;
  for (const float value : values) largest = std::max(largest, std::fabs(double{value}));
  if (!(largest > 0) || !std::isfinite(largest)) return 0;
  int exponent = 0;
  std::frexp(largest, &exponent);
  exponent -= bits - 1;
  return exponent >= kLeastExponent && exponent <= kMostExponent ? std::optional(exponent) : std::nullopt;
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
