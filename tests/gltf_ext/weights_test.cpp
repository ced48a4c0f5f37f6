#include "gltf_ext/weights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

std::vector<float> floats_of(const Attribute& attribute) {
  std::vector<float> values(attribute.values.size() / sizeof(float));
  std::memcpy(values.data(), attribute.values.data(), attribute.values.size());
  return values;
}

// Points with weights of two sets, eight numbers that sum to `sum` each.
Mesh weighted_mesh(uint32_t points, float sum) {
  std::mt19937 random(5);
  std::vector<float> first, second;
  for (uint32_t point = 0; point < points; ++point) {
    std::vector<float> weights(8);
    float total = 0;
    for (float& weight : weights) total += weight = static_cast<float>(random() % 1000);
    for (size_t k = 0; k < 8; ++k) (k < 4 ? first : second).push_back(weights[k] / total * sum);
  }
  Mesh mesh;
  mesh.point_count = points;
  mesh.attributes.push_back(make_attribute("WEIGHTS_0", ComponentType::kFloat32, 4, false, first));
  mesh.attributes.push_back(make_attribute("WEIGHTS_1", ComponentType::kFloat32, 4, false, second));
  return mesh;
}

TEST(Weights, StillSumToOneOnAGrid) {
  for (const int bits : {4, 8, 12, 16}) {
    Mesh mesh = weighted_mesh(500, 1);
    const std::vector<float> before[] = {floats_of(mesh.attributes[0]), floats_of(mesh.attributes[1])};
    const std::vector<AttributeCoding> codings(2, unit_grid(4, bits));
    round_weights(mesh, codings);
    const std::vector<float> after[] = {floats_of(mesh.attributes[0]), floats_of(mesh.attributes[1])};
    const float step_count = static_cast<float>((1 << bits) - 1);
    for (size_t point = 0; point < 500; ++point) {
      long steps = 0;
      for (size_t set = 0; set < 2; ++set)
        for (size_t k = 4 * point; k < 4 * point + 4; ++k) {
          steps += std::lround(after[set][k] * step_count);
          EXPECT_LE(std::fabs(after[set][k] - before[set][k]) * step_count, 1.01f);
        }
      EXPECT_EQ(steps, std::lround(step_count));
    }
  }
}

TEST(Weights, ThatDoNotSumToOneStayAsTheyAre) {
  Mesh mesh = weighted_mesh(50, 0.5f);
  const std::vector<std::byte> before = mesh.attributes[0].values;
  round_weights(mesh, std::vector<AttributeCoding>(2, unit_grid(4, 12)));
  EXPECT_EQ(mesh.attributes[0].values, before);
}

TEST(Weights, WithoutAGridStayAsTheyAre) {
  Mesh mesh = weighted_mesh(50, 1);
  const std::vector<std::byte> before = mesh.attributes[0].values;
  round_weights(mesh, std::vector<AttributeCoding>(2));
  EXPECT_EQ(mesh.attributes[0].values, before);
}

}  // namespace
}  // namespace psplit
