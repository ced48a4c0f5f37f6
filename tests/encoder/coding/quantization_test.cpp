#include "encoder/coding/quantization.h"

#include <cmath>
#include <cstring>
#include <random>

#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/sanitizers.h"

namespace psplit {
namespace {

Attribute floats(const char* semantic, uint8_t components, const std::vector<float>& values) {
  return make_attribute(semantic, ComponentType::kFloat32, components, false, values);
}

// As libdraco computes it.
float decoded(const AttributeCoding& grid, size_t component, int64_t step) {
  const auto steps = static_cast<float>((int64_t{1} << grid.bits) - 1);
  return grid.origin[component] + static_cast<float>(step) * (grid.range / steps);
}

TEST(FitGrid, EndsWhereGltfsLimitsEnd) {
  for (int bits = 1; bits <= 30; ++bits) {
    const auto color = must(fit_grid(floats("COLOR_0", 4, {0.1f, 0.2f, 2.8e-5f, 0.9f, 0, 0.3f, 1, 1}), bits));
    EXPECT_EQ(color.origin, std::vector<float>(4, 0.0f));
    EXPECT_EQ(decoded(color, 2, (int64_t{1} << color.bits) - 1), 1.0f) << bits;
    const auto tangent = must(fit_grid(floats("TANGENT", 4, {0.1f, 0.2f, 0.3f, 1, 0.4f, 0.1f, 0, -1}), bits));
    EXPECT_EQ(decoded(tangent, 3, 0), -1.0f);
    EXPECT_EQ(decoded(tangent, 3, (int64_t{1} << tangent.bits) - 1), 1.0f) << bits;
  }
}

// A grid of their own extent has colours closer. It is moved below the limits where it would end beyond them.
TEST(FitGrid, FitsColorsInsideTheLimits) {
  std::mt19937 random(1);
  const auto between = [&](float low, float high) {
    return low + (high - low) * static_cast<float>(random() >> 8) * 0x1p-24f;
  };
  for (size_t round = 0; round < fewer_with_sanitizers(3000); ++round) {
    const int bits = static_cast<int>(1 + round % 14);
    const float low = round % 3 == 0 ? 0 : between(0, 1), high = round % 3 == 1 ? 1 : between(low, 1);
    std::vector<float> values = {low, low, 1, high, between(low, high), 1};
    values.push_back(round % 2 == 0 ? 1 : between(low, high));
    values.insert(values.end(), {low, 1});
    const Attribute color = floats("COLOR_0", 3, values);
    const auto grid = must(fit_grid(color, bits));
    float extent = high - low;
    for (const size_t c : {0u, 1u, 2u}) {
      float least = 1, most = 0;
      for (size_t i = c; i < values.size(); i += 3) {
        least = std::min(least, values[i]);
        most = std::max(most, values[i]);
      }
      extent = std::max(extent, most - least);
    }
    for (size_t i = 0; i < values.size(); ++i) {
      const float place = grid_place(values[i], grid.origin[i % 3], grid.range, grid.bits);
      const float came_back = decoded(grid, i % 3, static_cast<int64_t>(place));
      EXPECT_TRUE(came_back >= 0 && came_back <= 1) << came_back;
      const double step = double{extent} / (std::ldexp(1.0, bits) - 1);
      EXPECT_NEAR(values[i], came_back, 0.5 * 1.001 * step + 2e-7) << low << " " << high << " " << bits;
      if (i % 3 == 2 && values[i] == 1 && round % 2 == 0) {
        EXPECT_EQ(came_back, 1.0f);  // opaque stays opaque
      }
    }
  }
}

TEST(FitGrid, KeepsColorsThatWereBytes) {
  const std::vector<float> values = {17 / 255.0f, 30 / 255.0f, 90 / 255.0f, 40 / 255.0f, 41 / 255.0f, 0};
  const auto grid = must(fit_grid(floats("COLOR_0", 3, values), 8));
  EXPECT_EQ(grid.range, 1);
  EXPECT_LT(fit_grid(floats("COLOR_0", 3, values), 7)->range, 0.36f);
}

TEST(FitGrid, HoldsAllValuesAndRefusesWhatIsNotFinite) {
  const auto grid = must(fit_grid(floats("POSITION", 3, {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}), 14));
  EXPECT_EQ(grid.origin, (std::vector<float>{0, 0, 0}));
  EXPECT_EQ(grid.range, 1.0f);
  EXPECT_FALSE(fit_grid(floats("POSITION", 3, {INFINITY, 0, 0}), 14).ok());
}

TEST(FitGrid, OfJoinedBoundsIsTheCubeOfTheirBox) {
  CodingBounds bounds = bounds_of(floats("POSITION", 3, {0, 5, 0, 8, 5, 0}), 14);
  bounds.add(bounds_of(floats("POSITION", 3, {-1, 7, 3, -1, 6, 3}), 14));
  const auto grid = must(fit_grid(floats("POSITION", 3, {}), bounds, 14));
  EXPECT_EQ(grid.origin, (std::vector<float>{-1, 5, 0}));
  EXPECT_EQ(grid.range, 9);
}

TEST(FitGrid, HoldsColorsBeyondOne) {
  const auto grid = must(fit_grid(floats("COLOR_0", 3, {0, 0, 0, 4, 1, 1}), 8));
  EXPECT_EQ(grid.range, 4.0f);
}

TEST(TrimNoise, TakesNoiseOnly) {
  Attribute tangent = floats("TANGENT", 4, {1.0000001f, 0, 0, 1, 2, -1.0000001f, 0, -1});
  trim_noise(tangent);
  EXPECT_EQ(values_of<float>(tangent), (std::vector<float>{1, 0, 0, 1, 2, -1, 0, -1}));
  Attribute texcoord = floats("TEXCOORD_0", 2, {1.0000001f, -1e-7f});
  trim_noise(texcoord);
  EXPECT_EQ(values_of<float>(texcoord), (std::vector<float>{1.0000001f, -1e-7f}));
}

TEST(RoundWeights, KeepsSumsOverAllSets) {
  for (const int bits : {1, 2, 5, 8, 12, 16, 24, 30}) {
    Mesh mesh;
    mesh.point_count = 3;
    const float third = 1.0f / 3.0f;
    mesh.attributes = {floats("WEIGHTS_0", 4, {third, third, third, 0, 0.5f, 0.25f, 0.0625f, 0, 0, 0, 0, 0}),
                       floats("WEIGHTS_1", 2, {0, 0, 0.15625f, 0.03125f, 0, 0})};
    std::vector<AttributeCoding> codings;
    for (const Attribute& attribute : mesh.attributes) codings.push_back(*fit_grid(attribute, bits));
    const Mesh before = mesh;
    round_weights(mesh, codings);
    const std::vector<float> first = values_of<float>(mesh.attributes[0]),
                             second = values_of<float>(mesh.attributes[1]);
    for (size_t point = 0; point < 3; ++point) {
      double sum = double{second[point * 2]} + double{second[point * 2 + 1]};
      for (size_t c = 0; c < 4; ++c) sum += double{first[point * 4 + c]};
      EXPECT_NEAR(sum, point == 2 ? 0.0 : 1.0, 2e-7) << bits << " bits, point " << point;
    }
    const double step = 1.0 / (std::ldexp(1.0, codings[0].bits) - 1);
    for (size_t i = 0; i < first.size(); ++i) {
      const float was = values_of<float>(before.attributes[0])[i];
      EXPECT_NEAR(first[i], was, step);
      // A joint that does not pull must not begin to.
      if (was == 0) {
        EXPECT_EQ(first[i], 0.0f);
      }
    }
  }
}

TEST(RoundWeights, MendsSumsThatAreNearlyOne) {
  Mesh mesh;
  mesh.point_count = 3;
  mesh.attributes = {
      floats("WEIGHTS_0", 4, {0.502f, 0.502f, 0, 0, 0.33f, 0.33f, 0.336f, 0, 0.25f, 0.25f, 0, 0})};
  round_weights(mesh, std::vector<AttributeCoding>{*fit_grid(mesh.attributes[0], 12)});
  const std::vector<float> values = values_of<float>(mesh.attributes[0]);
  EXPECT_NEAR(values[0] + values[1], 1, 2e-7);
  EXPECT_NEAR(values[4] + values[5] + values[6], 1, 2e-7);
  EXPECT_NEAR(values[8] + values[9], 0.5, 1.0 / 4095);
  for (const size_t i : {2u, 3u, 7u, 10u, 11u}) EXPECT_EQ(values[i], 0.0f);
}

TEST(RoundWeights, LeavesWhatIsKeptExactly) {
  Mesh mesh;
  mesh.point_count = 1;
  mesh.attributes = {floats("WEIGHTS_0", 4, {0.33f, 0.33f, 0.34f, 0})};
  const Array<std::byte> before = mesh.attributes[0].values;
  round_weights(mesh, std::vector<AttributeCoding>(1));
  EXPECT_EQ(mesh.attributes[0].values, before);
}

}  // namespace
}  // namespace psplit
