#include "tools/gltf_psplit/compare/meshopt_rival.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

#include "tests/support/choose_codings.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"
#include "tools/gltf_psplit/shapes/shapes.h"

namespace psplit {
namespace {

using GridPoint = std::array<uint16_t, 3>;

// Where psplit puts the positions of a mesh.
std::vector<GridPoint> grid_points(const Mesh& mesh, const AttributeCoding& coding) {
  std::vector<GridPoint> points(mesh.point_count);
  const Attribute& positions = *mesh.find("POSITION");
  for (size_t i = 0; i < points.size() * 3; ++i) {
    float value = 0;
    std::memcpy(&value, positions.values.data() + i * sizeof value, sizeof value);
    const double steps = (static_cast<double>(value) - coding.origin[i % 3]) / coding.range;
    points[i / 3][i % 3] = static_cast<uint16_t>(std::lround(steps * ((1 << coding.bits) - 1)));
  }
  return points;
}

TEST(MeshoptRival, GivesBackTheSameTrianglesWithTheBitsOfItsRivals) {
  const ThreadPool pool(2);
  const auto meshes = must(generate_shape({Shape::kBlob, 5000, 1, true, true}, pool));
  Mesh mesh = meshes.front();
  for (const int normal_bits : {6, 10, 12}) {
    CodingOptions options;
    options.normal_bits = normal_bits;
    const std::vector<AttributeCoding> codings = choose_codings(mesh, options);
    const auto encoded = must(encode_meshopt(mesh, codings));
    const auto decoded = must(decode_meshopt(encoded));
    for (const MeshoptForm form : meshopt_forms()) {
      const auto same = must(decode_meshopt(encoded, form));
      EXPECT_TRUE(same.indices == decoded.indices && same.streams == decoded.streams);
    }
    ASSERT_EQ(decoded.indices.size(), mesh.faces.size() * 3);
    ASSERT_EQ(decoded.streams.size(), 3u);
    EXPECT_EQ(encoded.streams[0].stride, 8u);  // 14 bits
    EXPECT_EQ(encoded.streams[1].stride, normal_bits <= 8 ? 4u : 8u);
    EXPECT_EQ(encoded.streams[2].stride, 4u);  // 12 bits
    EXPECT_LT(encoded.with_zstd.size(), mesh.faces.size() * 7);

    // Normals by positions, which are on the same grid to the bit.
    std::map<GridPoint, std::vector<std::array<float, 3>>> normals;
    const std::vector<GridPoint> points = grid_points(mesh, codings[0]);
    for (size_t i = 0; i < points.size(); ++i) {
      std::array<float, 3> normal{};
      std::memcpy(normal.data(), mesh.find("NORMAL")->values.data() + i * sizeof normal, sizeof normal);
      normals[points[i]].push_back(normal);
    }
    double worst = 0;
    for (size_t i = 0; i < encoded.point_count; ++i) {
      GridPoint point{};
      std::memcpy(point.data(), decoded.streams[0].data() + i * 8, sizeof point);
      ASSERT_TRUE(normals.contains(point));
      std::array<double, 3> normal{};
      for (size_t k = 0; k < 3; ++k)
        if (normal_bits <= 8) {
          normal[k] = static_cast<int8_t>(decoded.streams[1][i * 4 + k]) / 127.0;
        } else {
          int16_t value = 0;
          std::memcpy(&value, decoded.streams[1].data() + i * 8 + k * 2, sizeof value);
          normal[k] = value / 32767.0;
        }
      double nearest = HUGE_VAL;
      for (const auto& original : normals[point])
        nearest = std::min(
            nearest, std::hypot(normal[0] - original[0], normal[1] - original[1], normal[2] - original[2]));
      worst = std::max(worst, nearest);
    }
    EXPECT_LT(worst, 4.5 / std::ldexp(1.0, normal_bits)) << normal_bits;
    EXPECT_GT(worst, 0.5 / std::ldexp(1.0, normal_bits)) << normal_bits;
  }
}

TEST(MeshoptRival, QuantizesWhatItsRivalsQuantizeAndNothingElse) {
  Mesh mesh;
  mesh.point_count = 4;
  mesh.faces = {{0, 1, 2}, {2, 1, 3}};
  const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, ids{7, 8, 9, 70000};
  std::vector<float> colors, tangents;
  for (int i = 0; i < 16; ++i) colors.push_back(static_cast<float>(i) / 16);
  for (int i = 0; i < 4; ++i) tangents.insert(tangents.end(), {1, 0, 0, -1});
  mesh.attributes = {make_attribute("POSITION", ComponentType::kFloat32, 3, false, corners),
                     make_attribute("COLOR_0", ComponentType::kFloat32, 4, false, colors),
                     make_attribute("TANGENT", ComponentType::kFloat32, 4, false, tangents),
                     make_attribute("_FEATURE_ID_0", ComponentType::kFloat32, 1, false, ids),
                     make_attribute("_HEAT", ComponentType::kFloat32, 1, false, ids)};
  const auto strides = [&](const CodingOptions& options) {
    const auto encoded = encode_meshopt(mesh, choose_codings(mesh, options));
    std::vector<size_t> list;
    for (const MeshoptStream& stream : encoded->streams) list.push_back(stream.stride);
    return list;
  };
  CodingOptions fine, lossless;
  fine.position_bits = 20;
  fine.color_bits = 10;
  lossless.lossless = true;
  EXPECT_EQ(strides({}), (std::vector<size_t>{8, 4, 8, 4, 4}));
  EXPECT_EQ(strides(fine), (std::vector<size_t>{12, 8, 8, 4, 4}));
  EXPECT_EQ(strides(lossless), (std::vector<size_t>{12, 16, 16, 4, 4}));
}

// Releases from 1.0 on have a filter for them, which is used where it makes them smaller.
TEST(MeshoptRival, KeepsColorsToTheirBitsWithAndWithoutAFilter) {
  const ThreadPool pool(1);
  Mesh mesh = must(generate_shape({Shape::kTerrain, 2000, 1, false, false}, pool)).front();
  std::vector<float> colors;
  for (uint32_t point = 0; point < mesh.point_count; ++point) {
    const float grey = 0.5f + 0.25f * std::sin(static_cast<float>(point) * 0.1f);
    colors.insert(colors.end(), {grey, grey * 0.9f, grey * 0.8f});
  }
  mesh.attributes.push_back(make_attribute("COLOR_0", ComponentType::kFloat32, 3, false, colors));
  const std::vector<AttributeCoding> codings = choose_codings(mesh, {});
  const auto encoded = must(encode_meshopt(mesh, codings));
  const auto decoded = must(decode_meshopt(encoded));
  ASSERT_EQ(encoded.streams.size(), 2u);
  ASSERT_EQ(encoded.streams[1].stride, 4u);
  EXPECT_TRUE(meshopt_codec_version() > 0 || encoded.streams[1].filter == MeshoptFilter::kNone);
  // Sums of all values tell the colours apart from others without the order of points.
  const auto& [bits, octahedral, origin, range, exact] = codings[1];
  std::array<double, 3> difference{};
  for (size_t i = 0; i < colors.size(); ++i) difference[i % 3] += static_cast<double>(colors[i]);
  for (size_t point = 0; point < encoded.point_count; ++point)
    for (size_t k = 0; k < 3; ++k)
      difference[k] -= static_cast<double>(origin[k]) + decoded.streams[1][4 * point + k] * range / 255.0;
  ASSERT_EQ(encoded.point_count, mesh.point_count);
  for (const double sum : difference) EXPECT_NEAR(sum / mesh.point_count, 0, 1.0 * range / 255);
}

TEST(MeshoptRival, RefusesDamagedBytes) {
  const ThreadPool pool(1);
  const auto meshes = must(generate_shape({Shape::kTerrain, 2000, 1, false, false}, pool));
  Mesh mesh = meshes.front();
  auto encoded = must(encode_meshopt(mesh, choose_codings(mesh, {})));
  encoded.with_zstd.resize(encoded.with_zstd.size() / 2);
  encoded.with_brotli.resize(encoded.with_brotli.size() / 2);
  for (const MeshoptForm form : meshopt_forms())
    EXPECT_EQ(decode_meshopt(encoded, form).ok(), form == MeshoptForm::kPlain);
  EXPECT_TRUE(decode_meshopt(encoded, MeshoptForm::kPlain).ok());
  encoded.packed.resize(encoded.packed.size() / 2);
  EXPECT_FALSE(decode_meshopt(encoded, MeshoptForm::kPlain).ok());
}

}  // namespace
}  // namespace psplit
