#include "tools/gltf_psplit/compare/meshopt_rival.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "tools/gltf_psplit/shapes/shapes.h"

namespace psplit {
namespace {

TEST(MeshoptRival, GivesBackTheSameTrianglesOnItsGrid) {
  const ThreadPool pool(2);
  const auto meshes = generate_shape({Shape::kBlob, 5000, 1, true, true}, pool);
  ASSERT_TRUE(meshes.ok()) << meshes.status().to_string();
  const Mesh& mesh = meshes->front();
  const auto encoded = encode_meshopt(mesh, {});
  ASSERT_TRUE(encoded.ok());
  const auto decoded = decode_meshopt(*encoded);
  ASSERT_TRUE(decoded.ok());
  const auto plain = decode_meshopt(*encoded, MeshoptForm::kPlain);
  ASSERT_TRUE(plain.ok());
  EXPECT_TRUE(plain->indices == decoded->indices && plain->streams == decoded->streams);
  ASSERT_EQ(decoded->indices.size(), mesh.faces.size() * 3);
  ASSERT_EQ(decoded->streams.size(), 3u);
  EXPECT_EQ(encoded->streams[0].stride, 8u);
  EXPECT_EQ(encoded->streams[1].stride, 4u);
  EXPECT_EQ(encoded->streams[2].stride, 4u);
  EXPECT_LT(encoded->compressed.size(), mesh.faces.size() * 6);

  // Sums over all corners do not depend on the order of faces and points.
  const auto sum_of = [&](size_t component) {
    double sum = 0;
    for (const uint32_t point : decoded->indices) {
      uint16_t value = 0;
      std::memcpy(&value, decoded->streams[0].data() + point * 8 + component * 2, 2);
      sum += value;
    }
    return sum / static_cast<double>(decoded->indices.size());
  };
  const Attribute& positions = *mesh.find("POSITION");
  std::vector<float> values(positions.values.size() / 4);
  std::memcpy(values.data(), positions.values.data(), positions.values.size());
  float range = 0;
  std::array<float, 3> low{};
  for (size_t component = 0; component < 3; ++component) {
    float least = values[component], most = values[component];
    for (size_t i = component; i < values.size(); i += 3) {
      least = std::min(least, values[i]);
      most = std::max(most, values[i]);
    }
    low[component] = least;
    range = std::max(range, most - least);
  }
  for (size_t component = 0; component < 3; ++component) {
    double sum = 0;
    for (const auto& face : mesh.faces)
      for (const uint32_t point : face) sum += values[point * 3 + component] - low[component];
    const double mean_steps = sum / static_cast<double>(mesh.faces.size() * 3) / range * 16383;
    EXPECT_NEAR(sum_of(component), mean_steps, 0.1);
  }
}

TEST(MeshoptRival, RefusesDamagedBytes) {
  const ThreadPool pool(1);
  const auto meshes = generate_shape({Shape::kTerrain, 2000, 1, false, false}, pool);
  ASSERT_TRUE(meshes.ok());
  auto encoded = encode_meshopt(meshes->front(), {});
  ASSERT_TRUE(encoded.ok());
  encoded->compressed.resize(encoded->compressed.size() / 2);
  EXPECT_FALSE(decode_meshopt(*encoded).ok());
  EXPECT_TRUE(decode_meshopt(*encoded, MeshoptForm::kPlain).ok());
  encoded->packed.resize(encoded->packed.size() / 2);
  EXPECT_FALSE(decode_meshopt(*encoded, MeshoptForm::kPlain).ok());
}

}  // namespace
}  // namespace psplit
