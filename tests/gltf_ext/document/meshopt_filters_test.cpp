// The encoders of meshoptimizer's filters, undone by the extension's formulas.

#include "gltf_ext/document/meshopt_filters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/meshopt_codec.h"

namespace psplit {
namespace {

MeshoptRecord rows_of_filter(const char* filter, size_t stride, size_t count) {
  MeshoptRecord record;
  record.mode = "ATTRIBUTES";
  record.filter = filter;
  record.stride = stride;
  record.count = count;
  return record;
}

TEST(MeshoptFilters, MultiplesAreTheNearest) {
  const std::vector<float> values = {0, 1, -1, 0.3f, -0.7f, 100, 1e-3f, -99.99f};
  for (const int exponent : {-10, -3, 0, 4}) {
    std::vector<uint8_t> rows = filter_to_multiples(values, exponent);
    ASSERT_EQ(rows.size(), values.size() * sizeof(float));
    undo_meshopt_filter(rows_of_filter("EXPONENTIAL", 4, values.size()), rows.data());
    for (size_t i = 0; i < values.size(); ++i) {
      float decoded = 0;
      std::memcpy(&decoded, &rows[i * sizeof decoded], sizeof decoded);
      EXPECT_LE(std::fabs(decoded - values[i]), std::ldexp(0.5f, exponent));
      EXPECT_EQ(std::ldexp(decoded, -exponent), std::round(std::ldexp(decoded, -exponent)));
    }
  }
  EXPECT_TRUE(filter_to_multiples(values, -30).empty());
  const float nothing[] = {std::numeric_limits<float>::quiet_NaN()};
  EXPECT_TRUE(filter_to_multiples(nothing, 0).empty());
  EXPECT_EQ(exponent_for_bits(values, 16), 7 - 15);
  EXPECT_EQ(exponent_for_bits({}, 16), 0);
}

TEST(MeshoptFilters, RotationsKeepTheirLargestComponent) {
  std::vector<float> rotations;
  for (size_t largest = 0; largest < 4; ++largest)
    for (const float sign : {1.0f, -1.0f})
      for (size_t k = 0; k < 4; ++k) rotations.push_back(sign * (k == largest ? 0.9f : 0.2516611f));
  for (const int bits : {4, 12, 16}) {
    std::vector<uint8_t> rows = filter_rotations(rotations, bits);
    undo_meshopt_filter(rows_of_filter("QUATERNION", 8, rotations.size() / 4), rows.data());
    for (size_t i = 0; i < rotations.size(); ++i) {
      int16_t decoded = 0;
      std::memcpy(&decoded, &rows[i * sizeof decoded], sizeof decoded);
      const float sign = i / 4 % 2 == 0 ? 1.0f : -1.0f;
      EXPECT_NEAR(decoded / 32767.0, double{sign * rotations[i]}, 1.1 / (1 << bits) + 1e-4) << bits;
    }
  }
}

// Multiples in the upper bytes of their rows, and the same floats.
TEST(MeshoptFilters, LiftedMultiplesAreTheSameValues) {
  const auto values_of_rows = [](std::vector<uint8_t> rows) {
    undo_meshopt_filter(rows_of_filter("EXPONENTIAL", 4, rows.size() / 4), rows.data());
    return rows;
  };
  const std::vector<std::pair<std::vector<float>, size_t>> cases = {
      {{0, 1, -128, 127}, 2}, {{0, 1, 128}, 1}, {{-32768, 32767}, 1}, {{-32769}, 0}, {{0x7fffff}, 0}, {{0}, 2}};
  for (const auto& [values, free_bytes] : cases) {
    const std::vector<uint8_t> rows = filter_to_multiples(values, 0), lifted = lift_multiples(rows);
    EXPECT_EQ(values_of_rows(lifted), values_of_rows(rows));
    EXPECT_EQ(static_cast<int8_t>(lifted[3]), -8 * static_cast<int>(free_bytes)) << values.back();
  }
  const std::vector<float> tiny = {std::ldexp(1.0f, -100)};
  EXPECT_EQ(lift_multiples(filter_to_multiples(tiny, -100)), filter_to_multiples(tiny, -100));
}

// The specification's formula: numbers of 8, 6 and 16 bits, and rows that no encoder writes.
TEST(MeshoptFilters, ColorsAreTheFormula) {
  std::vector<uint8_t> bytes = {100, 20,   0xf6, 0xff, 63, 0, 0,   0x3f, 10,  0,
                                0,   0x20, 1,    2,    3,  0, 255, 127,  127, 0x80};
  undo_meshopt_filter(rows_of_filter("COLOR", 4, 5), bytes.data());
  EXPECT_EQ(bytes, (std::vector<uint8_t>{130, 90, 90, 255, 255, 255, 255, 255, 40, 40,
                                         40,  0,  0,  0,   0,   0,   255, 255, 1,  0}));
  const uint16_t wide[] = {4095, 0, 0, 0xfff, 1000, 500, static_cast<uint16_t>(-300), 0x801};
  std::vector<uint8_t> rows(sizeof wide);
  std::memcpy(rows.data(), wide, sizeof wide);
  undo_meshopt_filter(rows_of_filter("COLOR", 8, 2), rows.data());
  uint16_t decoded[8];
  std::memcpy(decoded, rows.data(), sizeof decoded);
  EXPECT_EQ(std::vector<uint16_t>(decoded, decoded + 8),
            (std::vector<uint16_t>{65535, 65535, 65535, 65535, 28807, 11203, 12803, 48}));
}

}  // namespace
}  // namespace psplit
