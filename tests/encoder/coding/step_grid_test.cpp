#include "encoder/coding/step_grid.h"

#include <cmath>
#include <random>

#include "encoder/coding/choose_codings.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/sanitizers.h"

namespace psplit {
namespace {

// What libdraco's arithmetic makes of the value.
float through_grid(const AttributeCoding& grid, size_t component, float value) {
  const auto steps = static_cast<float>((int64_t{1} << grid.bits) - 1);
  const float place = grid_place(value, grid.origin[component], grid.range, grid.bits);
  return place * (grid.range / steps) + grid.origin[component];
}

CodingBounds bounds_from(const std::vector<float>& values, uint8_t components = 1) {
  return bounds_of(float_attribute("_ID", components, values), 12);
}

TEST(FitWholeNumbers, KeepsEveryNumberOfEveryExtent) {
  std::mt19937 random(7);
  for (int bits = 0; bits <= 24; ++bits)
    for (const double least : {0.0, 1.0, -1.0, -1000.0, -std::floor(std::ldexp(1.0, bits) / 2), 5000000.0})
      for (const int power : {0, 1, 20, 50}) {
        const double extent = std::ldexp(1.0, bits) - 1;
        if (std::max(std::fabs(least), std::fabs(least + extent)) > std::ldexp(1.0, 24)) continue;
        const auto value = [&](double number) { return static_cast<float>(std::ldexp(number, power)); };
        const auto grid =
            fit_whole_numbers(bounds_from({value(least), value(least + extent), value(least + (bits > 1))}));
        ASSERT_TRUE(grid) << bits << " " << least << " " << power;
        EXPECT_TRUE(grid->exact);
        EXPECT_EQ(grid->bits, bits == 0 ? 1 : bits < 24 ? bits : 25);
        const size_t tries = bits <= 12 ? size_t{1} << bits : fewer_with_sanitizers(20000);
        for (size_t i = 0; i < tries; ++i) {
          const double offset =
              bits <= 12 ? static_cast<double>(i) : std::floor(extent * static_cast<double>(random()) / 0x1p32);
          const float number = value(least + offset);
          ASSERT_EQ(through_grid(*grid, 0, number), number) << bits << " " << power;
        }
        for (double end = 0; end < std::min(extent, 100.0); ++end)
          ASSERT_EQ(through_grid(*grid, 0, value(least + extent - end)), value(least + extent - end));
      }
}

TEST(FitWholeNumbers, KeepsAllOfThe24Bits) {
  const auto grid = fit_whole_numbers(bounds_from({0, 16777215, 1}));
  ASSERT_TRUE(grid);
  for (uint32_t i = 0; i < 1u << 24; i += kHasSanitizers ? 7 : 1) {
    const auto number = static_cast<float>(i);
    ASSERT_EQ(through_grid(*grid, 0, number), number);
  }
}

TEST(FitWholeNumbers, KeepsNumbersNearTheEndOfFloats) {
  const std::vector<float> values = {16777200, 16777216, 16777201};
  const auto grid = fit_whole_numbers(bounds_from(values));
  ASSERT_TRUE(grid);
  for (const float value : values) EXPECT_EQ(through_grid(*grid, 0, value), value);
}

TEST(FitWholeNumbers, HasAStepForAllComponents) {
  const std::vector<float> values = {0, 100, -3, 4095, 101, 7};
  const auto grid = fit_whole_numbers(bounds_from(values, 3));
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->bits, 12);
  for (size_t i = 0; i < values.size(); ++i) EXPECT_EQ(through_grid(*grid, i % 3, values[i]), values[i]);
}

TEST(FitWholeNumbers, RefusesOtherNumbers) {
  EXPECT_FALSE(fit_whole_numbers(bounds_from({})));
  EXPECT_FALSE(fit_whole_numbers(bounds_from({0, 1, 2.5f})));
  EXPECT_FALSE(fit_whole_numbers(bounds_from({0, 1, NAN})));
  EXPECT_FALSE(fit_whole_numbers(bounds_from({0, 1, INFINITY})));
  EXPECT_FALSE(fit_whole_numbers(bounds_from({0, 1, 1e-40f})));
  EXPECT_FALSE(fit_whole_numbers(bounds_from({-1, 16777216})));
  EXPECT_FALSE(fit_whole_numbers(bounds_from({1, 1e20f})));
}

TEST(ChooseCoding, KeepsWholeNumbersOfDataWhateverTheBits) {
  std::vector<float> ids;
  for (int i = 0; i < 20000; ++i) ids.push_back(static_cast<float>(i));
  for (const char* semantic : {"_BATCH_ID", "_OBJECTID", "_FEATURE_ID_0", "_BATCHID", "_ANY", "JOINTS_0"}) {
    Attribute attribute = float_attribute(semantic, 1, ids);
    const AttributeCoding coding = choose_coding(attribute, CodingOptions{});
    EXPECT_TRUE(coding.exact) << semantic;
    EXPECT_EQ(coding.bits, 15) << semantic;
    EXPECT_EQ(error_bounds(coding), std::vector<double>{0});
  }
  Attribute geometry = float_attribute("TEXCOORD_0", 2, ids);
  EXPECT_EQ(choose_coding(geometry, {}).bits, 12);
  Attribute large = float_attribute("_ANY", 1, {1, 2, 3e8f});
  EXPECT_EQ(choose_coding(large, {}).bits, 0);
  Attribute broken = float_attribute("_ANY", 1, {1, 2, 2.5f});
  EXPECT_EQ(choose_coding(broken, {}).bits, 12);
  EXPECT_EQ(choose_coding(large, {.lossless = true}).bits, 0);
}

TEST(ChooseCoding, TakesFewerBitsForWholeNumbersIfTheyAreGiven) {
  Attribute attribute = float_attribute("_ANY", 1, {0, 1, 4096});
  CodingOptions options{.generic_bits = 10, .given = {.generic = true}};
  EXPECT_FALSE(choose_coding(attribute, options).exact);
  options.generic_bits = 13;
  EXPECT_TRUE(choose_coding(attribute, options).exact);
  Attribute names = float_attribute("_FEATURE_ID_0", 1, {0, 1, 4096});
  options.generic_bits = 10;
  EXPECT_TRUE(choose_coding(names, options).exact);
}

// glTF wants w to be 1 or -1. Vectors that are longer than one are kept long.
TEST(FitGrid, KeepsTheSignOfTangents) {
  std::mt19937 random(5);
  for (int bits = 1; bits <= 28; ++bits)
    for (const float length : {1.0005f, 1.5f, 3.0f, 100.0f, 0.7f, 12345.6f})
      for (const float second : {-1.0f, 1.0f}) {
        std::vector<float> values;
        for (int i = 0; i < 50; ++i) {
          for (int c = 0; c < 3; ++c)
            values.push_back(length * (static_cast<float>(random() >> 8) * 0x1p-23f - 1));
          values.push_back(i % 2 == 0 ? 1 : second);
        }
        values[0] = length;
        Attribute tangent = float_attribute("TANGENT", 4, values);
        const AttributeCoding grid = must(fit_grid(tangent, bits));
        const double extent = std::max(2.0, 2.0 * double{length});
        EXPECT_LE(grid_step(grid), 1.001 * extent / (std::ldexp(1.0, bits) - 1));
        EXPECT_TRUE(grid_extremes(grid));
        for (size_t i = 0; i < values.size(); ++i) {
          const float back = through_grid(grid, i % 4, values[i]);
          if (i % 4 == 3) {
            ASSERT_EQ(back, values[i]) << bits << " " << length;
          }
          ASSERT_NEAR(back, values[i], error_bounds(grid)[i % 4]) << bits << " " << length;
        }
      }
}

}  // namespace
}  // namespace psplit
