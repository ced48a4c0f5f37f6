// Meshes at the places where their nodes put them are the same, no matter how mesh and node divide the
// transformation.

#include <cmath>
#include <cstring>

#include "gltf_ext/json/json.h"
#include "psplit/decode.h"
#include "psplit/document.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"
#include "tools/gltf_psplit/diff/compare_assets.h"
#include "tools/gltf_psplit/diff/compared_asset.h"
#include "tools/gltf_psplit/diff/elements.h"

namespace psplit {
namespace {

double number_at(const Attribute& attribute, size_t point, size_t component) {
  return psplit::number_at(
      {attribute.component_type, attribute.component_count, attribute.normalized,
       static_cast<uint32_t>(attribute.values.size() / attribute.stride()), attribute.values},
      point, component);
}

// A bent grid with normals.
Mesh bent_grid() {
  Mesh mesh = make_grid(20, 10);
  std::vector<float> positions, normals;
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    const double x = number_at(mesh.attributes[0], i, 0), y = number_at(mesh.attributes[0], i, 1);
    positions.insert(positions.end(),
                     {static_cast<float>(x), static_cast<float>(y), static_cast<float>(std::sin(x))});
    const double length = std::hypot(1, std::cos(x));
    normals.insert(normals.end(),
                   {static_cast<float>(-std::cos(x) / length), 0, static_cast<float>(1 / length)});
  }
  mesh.attributes = {make_attribute("POSITION", ComponentType::kFloat32, 3, false, positions),
                     make_attribute("NORMAL", ComponentType::kFloat32, 3, false, normals)};
  return mesh;
}

AssetMeshes placed(const Document& document) {
  const ThreadPool pool(1);
  const AssetMeshes meshes = must(read_asset_meshes(document, cpu_backend(), describe_stream, pool));
  AssetMeshes placed = must(place_meshes(document, meshes, {}));
  return placed;
}

AssetComparison compare(const Document& a, const Document& b) {
  const ThreadPool pool(1);
  const AssetComparison comparison = must(compare_assets(placed(a), placed(b), {}, {pool}));
  return comparison;
}

// Positions as multiples of `step`, which the node scales back.
Document as_integers(const Mesh& mesh, double step) {
  std::vector<uint16_t> places;
  for (uint32_t i = 0; i < mesh.point_count; ++i)
    for (size_t c = 0; c < 3; ++c)
      places.push_back(static_cast<uint16_t>(std::lround((number_at(mesh.attributes[0], i, c) + 2) / step)));
  std::vector<int8_t> normals;
  for (uint32_t i = 0; i < mesh.point_count; ++i)
    for (size_t c = 0; c < 3; ++c)
      normals.push_back(static_cast<int8_t>(std::lround(number_at(mesh.attributes[1], i, c) * 127)));
  Mesh integers = mesh;
  integers.attributes = {make_attribute("POSITION", ComponentType::kUint16, 3, false, places),
                         make_attribute("NORMAL", ComponentType::kInt8, 3, true, normals)};
  Document document = document_from_mesh(integers);
  document.json()["nodes"][0]["scale"] = {step, step, step};
  document.json()["nodes"][0]["translation"] = {-2, -2, -2};
  return document;
}

TEST(PlacedMeshes, NodesUndoWhatQuantizingToolsDo) {
  const Mesh mesh = bent_grid();
  const Document plain = document_from_mesh(mesh), integers = as_integers(mesh, 0.002);
  const AssetComparison comparison = compare(plain, integers);
  EXPECT_TRUE(comparison.same());
  ASSERT_EQ(comparison.values.size(), 2u);
  EXPECT_NEAR(comparison.values[1].tolerance, 0.001, 1e-4);
  EXPECT_GT(comparison.values[1].largest, 0.0005);
  Document moved = integers;
  moved.json()["nodes"][0]["translation"] = {-2, -2, -1.997};
  EXPECT_FALSE(compare(plain, moved).same());
}

TEST(PlacedMeshes, MirrorsTurnTrianglesAndNormals) {
  const Mesh mesh = bent_grid();
  Mesh mirrored = mesh;
  for (Attribute& attribute : mirrored.attributes)
    for (uint32_t i = 0; i < mesh.point_count; ++i) {
      const auto x = static_cast<float>(-number_at(attribute, i, 0));
      std::memcpy(attribute.values.data() + i * attribute.stride(), &x, sizeof x);
    }
  Document node = document_from_mesh(mesh);
  node.json()["nodes"][0]["scale"] = {-1, 1, 1};
  EXPECT_FALSE(compare(document_from_mesh(mirrored), node).same());  // its triangles face the other way
  for (auto& face : mirrored.faces) std::swap(face[0], face[2]);
  EXPECT_TRUE(compare(document_from_mesh(mirrored), node).same());
}

TEST(PlacedMeshes, RotatedAndStretchedNodesEqualWhatTheyDo) {
  const Mesh mesh = bent_grid();
  Document node = document_from_mesh(mesh);
  node.json()["nodes"][0]["rotation"] = {0, 0, std::sqrt(0.5), std::sqrt(0.5)};  // x to y
  node.json()["nodes"][0]["scale"] = {3, 1, 1};
  Mesh baked = mesh;
  for (uint32_t i = 0; i < mesh.point_count; ++i)
    for (Attribute& attribute : baked.attributes) {
      const bool normal = attribute.semantic == "NORMAL";
      double x = number_at(attribute, i, 0) * (normal ? 1.0 / 3 : 3.0), y = number_at(attribute, i, 1),
             z = number_at(attribute, i, 2);
      const double length = normal ? std::hypot(x, y, z) : 1;
      const float values[] = {static_cast<float>(-y / length), static_cast<float>(x / length),
                              static_cast<float>(z / length)};
      std::memcpy(attribute.values.data() + i * attribute.stride(), values, sizeof values);
    }
  const AssetComparison comparison = compare(node, document_from_mesh(baked));
  EXPECT_TRUE(comparison.same()) << comparison.first->attribute;
  EXPECT_LT(comparison.values[0].tolerance, 1e-5);
}

TEST(PlacedMeshes, RepeatedMeshesEqualOneThatHoldsAll) {
  const Mesh mesh = bent_grid();
  Document twice = document_from_mesh(mesh);
  twice.json()["nodes"].push_back({{"mesh", 0}, {"translation", {0, 0, 5}}});
  twice.json()["scenes"][0]["nodes"] = {0, 1};
  Mesh all = mesh;
  append_mesh(all, mesh);
  for (Attribute& attribute : all.attributes)
    for (uint32_t i = mesh.point_count; attribute.semantic == "POSITION" && i < 2 * mesh.point_count; ++i) {
      const auto z = static_cast<float>(number_at(attribute, i, 2) + 5);
      std::memcpy(attribute.values.data() + i * attribute.stride() + 8, &z, sizeof z);
    }
  EXPECT_TRUE(compare(twice, document_from_mesh(all)).same());
  EXPECT_FALSE(compare(document_from_mesh(mesh), document_from_mesh(all)).same());

  // A scene that needs far more memory than its file is refused.
  for (int i = 0; i < 60'000; ++i) twice.json()["scenes"][0]["nodes"].push_back(0);
  const ThreadPool pool(1);
  const AssetMeshes meshes = must(read_asset_meshes(twice, cpu_backend(), describe_stream, pool));
  AssetMeshes large = meshes;
  large.primitives[0].view.point_count = 1000;
  const Expected<AssetMeshes> refused = place_meshes(twice, large, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.status().code(), StatusCode::kUnsupported);
}

}  // namespace
}  // namespace psplit
