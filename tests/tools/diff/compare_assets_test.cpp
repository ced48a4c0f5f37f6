// Which meshes count as equal, and the reports about meshes that differ.
#include "tools/gltf_psplit/diff/compare_assets.h"

#include "psplit/decode.h"
#include "psplit/document.h"
#include "tests/gltf_ext/asset.h"
#include "tools/gltf_psplit/diff/elements.h"

namespace psplit {
namespace {

AssetMeshes asset_of(std::vector<Mesh> primitives) {
  AssetMeshes asset;
  asset.whole_count = 1;
  for (Mesh& mesh : primitives) {
    AssetPrimitive& primitive = asset.primitives.emplace_back();
    primitive.id = {0, asset.primitives.size() - 1};
    primitive.take(std::move(mesh));
  }
  return asset;
}

AssetMeshes meshes_of(const Document& document) {
  return must(read_asset_meshes(document, cpu_backend(), describe_stream, test_pool()));
}

AssetComparison compare(const AssetMeshes& a, const AssetMeshes& b, const CompareRules& rules = {}) {
  return must(compare_assets(a, b, rules, {test_pool()}));
}

// Changes the mesh of a primitive.
template <typename Change>
void change(AssetPrimitive& primitive, const Change& change_mesh) {
  Mesh mesh;
  mesh.point_count = primitive.view.point_count;
  for (const auto& [semantic, values] : primitive.view.attributes)
    mesh.attributes.push_back({semantic, values.component_type, values.component_count, values.normalized,
                               Array<std::byte>(values.bytes.begin(), values.bytes.end())});
  mesh.faces.resize(primitive.element_count());
  std::memcpy(mesh.faces.data(), primitive.view.indices.bytes.data(), primitive.view.indices.bytes.size());
  change_mesh(mesh);
  primitive.take(std::move(mesh));
}

bool same(const AssetMeshes& a, const AssetMeshes& b, const CompareRules& rules = {}) {
  return compare(a, b, rules).same();
}

CompareRules within(double share) { return {{{"", share}}, {}}; }

void set_value(Mesh& mesh, const char* semantic, size_t index, float value) {
  for (Attribute& attribute : mesh.attributes)
    if (attribute.semantic == semantic)
      std::memcpy(attribute.values.data() + index * sizeof value, &value, sizeof value);
}

// A mesh with these faces and all points of `mesh`.
Mesh cut(const Mesh& mesh, size_t begin, size_t end) {
  Mesh part = mesh;
  part.faces.assign(mesh.faces.begin() + static_cast<ptrdiff_t>(begin),
                    mesh.faces.begin() + static_cast<ptrdiff_t>(end));
  return part;
}

TEST(CompareAssets, WhatEncodeMakesOfAnAssetIsTheSame) {
  const Document original = document_from_mesh(rich_mesh(40, 30));
  const AssetMeshes a = meshes_of(original);
  for (const Compat compat : {Compat::kNone, Compat::kKhr})
    for (const bool lossless : {false, true}) {
      Document split = original;
      ASSERT_TRUE(
          encode(split, DocumentOptions{.patches = {.count = 7}, .lossless = lossless, .compat = compat}));
      const AssetMeshes b = meshes_of(split);
      const AssetComparison there = compare(a, b), back = compare(b, a);
      EXPECT_TRUE(there.same() && back.same());
      EXPECT_EQ(there.recut_meshes, compat == Compat::kKhr ? 1u : 0u);
      EXPECT_EQ(there.a.triangles, 2400u);
      EXPECT_EQ(same(a, b, within(0)), lossless);
      for (const AssetComparison::Values& values : there.values) {
        EXPECT_LE(values.largest, values.tolerance) << values.attribute;
        const bool is_float = rich_mesh(1, 1).find(values.attribute)->component_type == ComponentType::kFloat32;
        EXPECT_EQ(values.tolerance > 0, is_float && !lossless) << values.attribute;
      }
      ASSERT_TRUE(decode(split).ok());
      const AssetMeshes decoded = meshes_of(split);
      EXPECT_TRUE(same(b, decoded, within(0)));
      EXPECT_EQ(same(a, decoded), lossless);  // decoded files state no grids
    }
}

TEST(CompareAssets, OneGridMeansEqualValues) {
  // A quarter of a step is within half a step of the original value, but it is not a value of the same grid.
  Document split = document_from_mesh(make_grid(10, 10));
  ASSERT_TRUE(encode(split));
  const AssetMeshes a = meshes_of(split);
  AssetMeshes b = a, plain = a;
  plain.primitives[0].grids.clear();
  float value;
  std::memcpy(&value, b.primitives[0].view.attributes[0].values.at(0), sizeof value);
  value += static_cast<float>(a.primitives[0].grids.at("POSITION").within / 2);
  for (AssetMeshes* asset : {&b, &plain})
    change(asset->primitives[0], [&](Mesh& mesh) { set_value(mesh, "POSITION", 0, value); });
  EXPECT_FALSE(same(a, b));
  EXPECT_TRUE(same(a, plain));
}

TEST(CompareAssets, AMovedPointIsNamedWithBothItsValues) {
  const Mesh mesh = rich_mesh();
  Mesh moved = mesh;
  set_value(moved, "POSITION", 3 * 40 + 1, 77);
  const AssetComparison comparison = compare(asset_of({mesh}), asset_of({moved}));
  ASSERT_FALSE(comparison.same());
  const AssetDifference& first = *comparison.first;
  const auto around =
      std::ranges::find_if(mesh.faces, [](const auto& face) { return std::ranges::count(face, 40u) > 0; });
  EXPECT_EQ(first.element, around - mesh.faces.begin());
  EXPECT_EQ(first.partner, first.element);
  EXPECT_EQ((*around)[static_cast<size_t>(first.corner)], 40u);
  EXPECT_EQ(first.attribute, "POSITION");
  EXPECT_EQ(first.other.at(1), 77);
  EXPECT_EQ(first.value.at(0), first.other.at(0));
  EXPECT_EQ(comparison.a.alone, 6u);
  EXPECT_EQ(comparison.b.alone, 6u);
}

TEST(CompareAssets, EveryAttributeCounts) {
  const Mesh mesh = rich_mesh();
  for (size_t i = 0; i < mesh.attributes.size(); ++i) {
    Mesh other = mesh;
    Array<std::byte>& values = other.attributes[i].values;
    const size_t last = (40 + 1) * other.attributes[i].stride() - 1;  // this byte has the sign of a float
    values[last] ^= std::byte{0x40};
    const AssetComparison comparison = compare(asset_of({mesh}), asset_of({other}));
    ASSERT_FALSE(comparison.same()) << mesh.attributes[i].semantic;
    EXPECT_EQ(comparison.first->attribute, mesh.attributes[i].semantic);
    EXPECT_EQ(same(asset_of({mesh}), asset_of({other}), {{}, {"TEXCOORD_0"}}),
              i != 0 && mesh.attributes[i].semantic != "TEXCOORD_0");
  }
}

TEST(CompareAssets, ValuesSwappedOnASeamDiffer) {
  // Two points at the same position differ only in texture coordinates.
  Mesh mesh = make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, {{0, 1, 2}, {3, 5, 4}});
  mesh.attributes.push_back(make_attribute<float>("TEXCOORD_0", ComponentType::kFloat32, 2, false,
                                                  {0, 0, 1, 0, 0, 1, 0.25f, 0, 0.25f, 1, 1, 1}));
  Mesh swapped = mesh;
  swapped.faces = {{0, 3, 2}, {1, 5, 4}};
  EXPECT_TRUE(same(asset_of({mesh}), asset_of({swapped}), {{}, {"POSITION"}}));
  const AssetComparison comparison = compare(asset_of({mesh}), asset_of({swapped}), within(0.01));
  ASSERT_FALSE(comparison.same());
  EXPECT_EQ(comparison.first->attribute, "TEXCOORD_0");
  EXPECT_EQ(comparison.first->corner, 1);
  EXPECT_EQ(comparison.first->value, (std::vector<double>{1, 0}));
  EXPECT_EQ(comparison.first->other, (std::vector<double>{0.25, 0}));
}

TEST(CompareAssets, MissingExtraAndMirroredTrianglesAreNamed) {
  const Mesh mesh = make_grid(8, 8);
  const Mesh less = cut(mesh, 0, mesh.faces.size() - 1);
  const AssetComparison missing = compare(asset_of({mesh}), asset_of({less}));
  ASSERT_FALSE(missing.same());
  EXPECT_FALSE(missing.first->in_b);
  EXPECT_EQ(missing.first->element, 127);
  EXPECT_EQ(missing.first->what, "has no counterpart");
  EXPECT_EQ(missing.b.alone, 0u);
  const AssetComparison extra = compare(asset_of({less}), asset_of({mesh}));
  ASSERT_FALSE(extra.same());
  EXPECT_TRUE(extra.first->in_b);
  EXPECT_EQ(extra.first->element, 127);

  Mesh twice = mesh;
  twice.faces.push_back(mesh.faces[5]);
  const AssetComparison more = compare(asset_of({mesh}), asset_of({twice}));
  ASSERT_FALSE(more.same());
  EXPECT_EQ(more.first->what, "occurs more often than in the other file");

  Mesh mirrored = mesh;
  std::swap(mirrored.faces[20][0], mirrored.faces[20][1]);
  const AssetComparison turned = compare(asset_of({mesh}), asset_of({mirrored}));
  ASSERT_FALSE(turned.same());
  EXPECT_EQ(turned.first->what, "is mirrored");
  EXPECT_EQ(turned.first->element, 20);
  EXPECT_EQ(turned.first->partner, 20);
}

TEST(CompareAssets, DegenerateTrianglesAndUnusedPointsAreCountedOnly) {
  Mesh mesh = make_grid(4, 4);
  Mesh more = mesh;
  more.faces.push_back({0, 0, 1});
  set_value(more, "POSITION", 0, 0);
  ++more.point_count;
  more.attributes[0].values.resize(more.point_count * size_t{12});
  set_value(more, "POSITION", 3 * (more.point_count - 1), 9);
  const AssetComparison comparison = compare(asset_of({mesh}), asset_of({more}));
  EXPECT_TRUE(comparison.same());
  EXPECT_EQ(comparison.b.degenerate_alone, 1u);
  EXPECT_EQ(comparison.b.unused_points, 1u);
  EXPECT_EQ(comparison.b.alone, 0u);
}

// Other encoders drop the faces that their grid collapses. The answer does not depend on whether the other file
// is on a grid, too.
TEST(CompareAssets, FacesThatAGridCollapsesAreCountedOnly) {
  const Document original = document_from_mesh(make_grid(40, 40));
  Document split = original;
  ASSERT_TRUE(encode(split, DocumentOptions{.position_bits = 4}));
  const AssetMeshes plain = meshes_of(original), whole = meshes_of(split);
  AssetMeshes dropped = whole;
  size_t flat = 0;
  change(dropped.primitives[0], [&](Mesh& mesh) {
    const std::vector<std::array<float, 3>> places = values_of<std::array<float, 3>>(mesh.attributes[0]);
    flat = std::erase_if(mesh.faces, [&](const auto& face) {
      return places[face[0]] == places[face[1]] || places[face[1]] == places[face[2]] ||
             places[face[2]] == places[face[0]];
    });
  });
  ASSERT_TRUE(flat > 1000 && flat < 3200);
  for (const AssetMeshes* other : {&plain, &whole}) {
    const AssetComparison there = compare(*other, dropped), back = compare(dropped, *other);
    EXPECT_TRUE(there.same() && back.same());
    EXPECT_EQ(there.a.degenerate_alone, flat);
    EXPECT_EQ(back.b.degenerate_alone, flat);
  }
  // A primitive that is missing as a whole is not one that the grid of another one collapsed.
  AssetMeshes more = plain;
  AssetPrimitive small = plain.primitives[0];
  change(small, [](Mesh& mesh) {
    std::vector<float> values = values_of<float>(mesh.attributes[0]);
    for (float& value : values) value = value * 1e-3f + 100;
    std::memcpy(mesh.attributes[0].values.data(), values.data(), mesh.attributes[0].values.size());
  });
  more.primitives.push_back(small);
  EXPECT_FALSE(same(more, whole) || same(whole, more));
  // A face with an area on the grid.
  change(dropped.primitives[0], [](Mesh& mesh) { mesh.faces.pop_back(); });
  for (const AssetMeshes* other : {&plain, &whole})
    EXPECT_FALSE(same(*other, dropped) || same(dropped, *other));
}

TEST(CompareAssets, PrimitivesMayBeCutAndReordered) {
  const Mesh mesh = rich_mesh();
  AssetMeshes whole = asset_of({mesh}),
              parts = asset_of({cut(mesh, 100, mesh.faces.size()), cut(mesh, 0, 100)});
  EXPECT_TRUE(same(whole, parts));
  EXPECT_TRUE(same(parts, asset_of({cut(mesh, 0, 100), cut(mesh, 100, mesh.faces.size())})));
  EXPECT_FALSE(same(whole, asset_of({cut(mesh, 0, 100), cut(mesh, 101, mesh.faces.size())})));
  // Materials count only if both assets have equally many.
  whole.material_count = parts.material_count = 2;
  for (AssetPrimitive& primitive : parts.primitives) primitive.material = 1;
  EXPECT_FALSE(same(whole, parts));
  whole.primitives[0].material = 1;
  EXPECT_TRUE(same(whole, parts));
  parts.primitives[0].material = 0;
  const AssetComparison comparison = compare(whole, parts);
  EXPECT_FALSE(comparison.same());
  parts.material_count = 3;
  EXPECT_TRUE(same(whole, parts));
}

TEST(CompareAssets, PrimitivesOfOtherKindsSaySo) {
  const Mesh mesh = rich_mesh();
  Mesh less = mesh;
  less.attributes.erase(less.attributes.begin() + 3);
  EXPECT_EQ(compare(asset_of({mesh}), asset_of({less})).first->what,
            "has TEXCOORD_0, which the other file lacks");
  EXPECT_EQ(compare(asset_of({less}), asset_of({mesh})).first->what,
            "lacks TEXCOORD_0, which the other file has");
  EXPECT_TRUE(same(asset_of({less}), asset_of({mesh}), {{}, {"NORMAL", "_FEATURE_ID_0"}}));
  AssetMeshes lines = asset_of({mesh});
  lines.primitives[0].corner_count = 2;
  EXPECT_EQ(compare(asset_of({mesh}), lines).first->what, "has triangles, but lines in the other file");
  AssetMeshes two = asset_of({mesh});
  two.whole_count = 2;
  EXPECT_EQ(compare(asset_of({mesh}), two).first->what, "the files have 1 and 2 meshes");
}

TEST(CompareAssets, OtherTypesOfOneValueAreTheSame) {
  Mesh floats = make_grid(6, 6), bytes = floats, joints = floats;
  std::vector<float> color;
  std::vector<uint8_t> color_bytes, small;
  std::vector<uint16_t> large;
  for (uint32_t i = 0; i < floats.point_count; ++i) {
    color.insert(color.end(), {0.3f, static_cast<float>(i) / 100, 1});
    for (size_t c = 0; c < 3; ++c)
      color_bytes.push_back(static_cast<uint8_t>(std::lround(color[3 * i + c] * 255)));
    small.push_back(static_cast<uint8_t>(i));
    large.push_back(static_cast<uint16_t>(i));
  }
  floats.attributes.push_back(make_attribute("COLOR_0", ComponentType::kFloat32, 3, false, color));
  bytes.attributes.push_back(make_attribute("COLOR_0", ComponentType::kUint8, 3, true, color_bytes));
  EXPECT_TRUE(same(asset_of({floats}), asset_of({bytes})));
  EXPECT_FALSE(same(asset_of({floats}), asset_of({bytes}), within(0)));
  Mesh other = bytes;
  other.attributes[1].values[10] ^= std::byte{1};
  EXPECT_FALSE(same(asset_of({bytes}), asset_of({other})));

  Mesh wide = joints;
  joints.attributes.push_back(make_attribute("_FEATURE_ID_0", ComponentType::kUint8, 1, false, small));
  wide.attributes.push_back(make_attribute("_FEATURE_ID_0", ComponentType::kUint16, 1, false, large));
  EXPECT_TRUE(same(asset_of({joints}), asset_of({wide})));
  large[7] = 8;
  wide.attributes[1] = make_attribute("_FEATURE_ID_0", ComponentType::kUint16, 1, false, large);
  EXPECT_FALSE(same(asset_of({joints}), asset_of({wide}), within(0.5)));
}

TEST(CompareAssets, StatedTolerancesAreSharesOfTheExtent) {
  const Mesh mesh = rich_mesh();
  Mesh moved = mesh;
  float z;
  std::memcpy(&z, mesh.attributes[0].values.data() + (3 * 40 + 2) * sizeof z, sizeof z);
  float largest = 0;
  for (const float value : values_of<float>(mesh.attributes[0])) largest = std::max(largest, value);
  set_value(moved, "POSITION", 3 * 40 + 2, z + largest / 100);
  EXPECT_FALSE(same(asset_of({mesh}), asset_of({moved}), within(0.005)));
  EXPECT_TRUE(same(asset_of({mesh}), asset_of({moved}), within(0.011)));
  EXPECT_TRUE(same(asset_of({mesh}), asset_of({moved}), {{{"POSITION", 0.011}}, {}}));
  EXPECT_FALSE(same(asset_of({mesh}), asset_of({moved}), {{{"", 0.02}, {"POSITION", 0}}, {}}));
}

TEST(CompareAssets, WeightsThatEncodersSetRightAreTheSame) {
  Mesh mesh = make_grid(8, 8);
  std::vector<float> weights;
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    const float first = static_cast<float>(i) / 100;
    weights.insert(weights.end(), {first, 1.008f - first, 0, 0});  // like the output of other quantizers
  }
  mesh.attributes.push_back(make_attribute("WEIGHTS_0", ComponentType::kFloat32, 4, false, weights));
  const Document original = document_from_mesh(mesh);
  Document split = original;
  ASSERT_TRUE(encode(split));
  EXPECT_TRUE(same(meshes_of(original), meshes_of(split)));
  EXPECT_TRUE(same(meshes_of(split), meshes_of(original)));
  AssetMeshes other = meshes_of(original);
  change(other.primitives[0], [&](Mesh& moved) {
    set_value(moved, "WEIGHTS_0", 4 * 30, weights[4 * 30] + 0.004f);
    set_value(moved, "WEIGHTS_0", 4 * 30 + 1, weights[4 * 30 + 1] - 0.004f);
  });
  const AssetComparison comparison = compare(other, meshes_of(split));
  ASSERT_FALSE(comparison.same());
  EXPECT_EQ(comparison.first->attribute, "WEIGHTS_0");
}

TEST(CompareAssets, CracksAreSaid) {
  const Mesh whole = make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, {{0, 1, 2}, {1, 3, 2}});
  const Mesh torn = make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 1.01f, 0, 0}, {{0, 1, 2}, {4, 3, 2}});
  AssetMeshes a = asset_of({whole}), b = asset_of({torn});
  b.primitives[0].grids["POSITION"] = {0.05, "5"};
  const AssetComparison comparison = compare(a, b);
  ASSERT_FALSE(comparison.same());
  EXPECT_EQ(comparison.first->what, "is separated from its neighbour in the second file");
  EXPECT_EQ(comparison.first->value, (std::vector<double>{1, 0, 0}));
  EXPECT_EQ(comparison.a.alone + comparison.b.alone, 0u);
}

TEST(CompareAssets, PrimitivesWithoutDataAreCountedAndNotCompared) {
  Document whole = document_from_mesh(make_grid(3, 3)), empty = whole;
  empty.buffers[0] = {};  // an unknown extension would supply the bytes
  const AssetMeshes with = meshes_of(whole), without = meshes_of(empty);
  EXPECT_TRUE(without.primitives.at(0).has_no_data);
  const AssetComparison equal = compare(without, without);
  EXPECT_TRUE(equal.same());
  EXPECT_EQ(equal.a.without_data, 1u);
  EXPECT_EQ(equal.a.triangles, 0u);
  const AssetComparison different = compare(with, without);
  ASSERT_FALSE(different.same());
  EXPECT_EQ(different.first->what, "the files have 0 and 1 primitives without data");
}

TEST(CompareAssets, MorphTargetsLinesAndPointsAreRead) {
  Document document = document_from_mesh(make_grid(3, 2));
  const size_t points = 12;
  std::vector<float> deltas(3 * points, 0.5f);
  const auto morph = append_accessor(document, make_data(ComponentType::kFloat32, 3, deltas), 0, false);
  primitive_of(document)["targets"] = Json::array({{{"POSITION", morph}}});
  deltas[10] = 0.75f;
  Document moved = document;
  const auto other = append_accessor(moved, make_data(ComponentType::kFloat32, 3, deltas), 0, false);
  primitive_of(moved)["targets"][0]["POSITION"] = other;
  EXPECT_TRUE(same(meshes_of(document), meshes_of(document)));
  const AssetComparison comparison = compare(meshes_of(document), meshes_of(moved));
  ASSERT_FALSE(comparison.same());
  EXPECT_EQ(comparison.first->attribute, "targets/0/POSITION");

  const auto with_indices = [&](int mode, const std::vector<uint16_t>& indices) {
    Document drawn = document_from_mesh(make_grid(3, 2));
    primitive_of(drawn)["mode"] = mode;
    primitive_of(drawn)["indices"] =
        append_accessor(drawn, make_data(ComponentType::kUint16, 1, indices), 0, false);
    return meshes_of(drawn);
  };
  EXPECT_TRUE(same(with_indices(1, {0, 1, 1, 2, 2, 0}), with_indices(2, {1, 2, 0})));
  EXPECT_TRUE(same(with_indices(3, {0, 1, 2, 0}), with_indices(1, {2, 1, 0, 1, 2, 0})));
  EXPECT_FALSE(same(with_indices(3, {0, 1, 2}), with_indices(2, {0, 1, 2})));
  EXPECT_TRUE(same(with_indices(0, {0, 5, 2}), with_indices(0, {5, 2, 0})));
  EXPECT_FALSE(same(with_indices(0, {0, 5, 2}), with_indices(0, {5, 2, 2})));
  EXPECT_FALSE(same(with_indices(0, {0, 5}), with_indices(1, {0, 5})));
}

// Points and lines have no stream that states a grid. meshoptimizer's filter states exponents.
TEST(CompareAssets, PointsMayBeRoundedAsTheFilterStates) {
  const Mesh grid = make_grid(50, 40);
  std::vector<float> positions = values_of<float>(grid.attributes[0]);
  for (size_t i = 0; i < positions.size(); ++i) positions[i] += 0.1f * std::sin(static_cast<float>(i));
  Document document = document_from_mesh(make_mesh(positions, grid.faces));
  primitive_of(document)["mode"] = 0;
  primitive_of(document).erase("indices");
  const auto encoded = [&](double max_position_error) {
    Document copy = document;
    EncodeDocumentOptions options;
    options.meshopt = MeshoptRest::kExt;
    options.max_position_error = max_position_error;
    must(encode_document(copy, options, cpu_backend(), test_pool()));
    return copy;
  };
  constexpr double kError = 1.0 / 256;
  const AssetMeshes exact = meshes_of(document), rounded = meshes_of(encoded(kError));
  const AssetComparison comparison = compare(exact, rounded);
  EXPECT_TRUE(comparison.same());
  ASSERT_FALSE(comparison.values.empty());
  EXPECT_GT(comparison.values[0].largest, 0);
  EXPECT_LE(comparison.values[0].tolerance, kError);
  EXPECT_TRUE(same(rounded, exact));
  // Two files of the same exponents must be equal, and others differ by no more than both may.
  EXPECT_TRUE(same(rounded, rounded));
  EXPECT_TRUE(same(rounded, meshes_of(encoded(kError / 8))));
  for (const float move : {0.9f, 1.1f}) {
    AssetMeshes moved = exact;
    change(moved.primitives[0], [&](Mesh& mesh) {
      const auto to = static_cast<float>(number_at(*rounded.primitives[0].view.find("POSITION"), 0, 0));
      set_value(mesh, "POSITION", 0, to + move * static_cast<float>(comparison.values[0].tolerance));
    });
    EXPECT_EQ(same(moved, rounded), move < 1);
  }
}

}  // namespace
}  // namespace psplit
