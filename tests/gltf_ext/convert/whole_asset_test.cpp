// Data that depends on the geometry of an asset and must follow it or stay unchanged: morph targets, skins,
// instances, ids, sparse and interleaved accessors.
#include <algorithm>
#include <map>

#include "gltf_ext/json/json_fields.h"
#include "psplit/document.h"
#include "tests/gltf_ext/asset.h"

namespace psplit {
namespace {

EncodeDocumentOptions options_of(bool lossless, uint64_t patches = 4) {
  const EncodeDocumentOptions options = DocumentOptions{.patches = {.count = patches}, .lossless = lossless};
  return options;
}

std::vector<float> bumps(const Mesh& mesh, uint32_t every) {
  std::vector<float> deltas(3 * mesh.point_count, 0);
  for (uint32_t i = 0; i < mesh.point_count; i += every) deltas[3 * i + 2] = 1 + static_cast<float>(i);
  return deltas;
}

int64_t append_sparse(Document& document, const std::vector<float>& deltas) {
  const AccessorData data = make_data(ComponentType::kFloat32, 3, deltas);
  Json accessor = describe_stored(data);
  store_values_sparse(document, accessor, data, 34962);
  accessor["min"] = accessor["max"] = Json::array({0, 0, 0});
  document.json()["accessors"].push_back(accessor);
  return static_cast<int64_t>(document.json()["accessors"].size() - 1);
}

// For each position of the mesh, the morph targets of its point.
std::multimap<std::array<float, 3>, std::vector<float>> morphs_by_position(const Document& document,
                                                                           size_t primitive = 0) {
  const Expected<Mesh> mesh = read(document, 0, primitive);
  const auto morphs = read_morph_targets(document, {0, primitive});
  std::multimap<std::array<float, 3>, std::vector<float>> found;
  if (!mesh || !morphs) return found;
  const std::vector<float> positions = values_of<float>(*mesh->find("POSITION"));
  for (uint32_t i = 0; i < mesh->point_count; ++i) {
    std::vector<float> all;
    for (const MorphAttribute& morph : *morphs) {
      EXPECT_EQ(morph.data.count, mesh->point_count);
      for (size_t c = 0; c < 3; ++c) {
        float value = 0;
        std::memcpy(&value, morph.data.values.data() + (3 * i + c) * sizeof value, sizeof value);
        all.push_back(value);
      }
    }
    found.emplace(std::array{positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]}, all);
  }
  return found;
}

const Json& target_accessor(const Document& document, size_t target) {
  const Json& primitive = document.json()["meshes"][0]["primitives"][0];
  return document.json()["accessors"][primitive["targets"][target]["POSITION"].get<size_t>()];
}

// Three targets: sparse, dense, and all zero. The first accessor is used by two of them.
Document morphing_asset(const Mesh& mesh) {
  Document document = document_from_mesh(mesh);
  const int64_t sparse = append_sparse(document, bumps(mesh, 17));
  const int64_t dense = append_accessor(
      document, make_data(ComponentType::kFloat32, 3, values_of<float>(mesh.attributes[0])), 34962, true);
  const int64_t zero = append_sparse(document, std::vector<float>(3 * mesh.point_count, 0));
  primitive_of(document)["targets"] = Json::array(
      {{{"POSITION", sparse}}, {{"POSITION", dense}}, {{"POSITION", zero}}, {{"POSITION", sparse}}});
  return document;
}

TEST(MorphTargets, SparseOnesStaySparseAndFollowTheirPoints) {
  const Mesh mesh = make_grid(16, 12);
  Document document = morphing_asset(mesh);
  ASSERT_TRUE(target_accessor(document, 0).contains("sparse"));
  const auto before = morphs_by_position(document);
  ASSERT_EQ(before.size(), mesh.point_count);
  const std::vector<float> deltas = bumps(mesh, 17);
  const float highest = *std::max_element(deltas.begin(), deltas.end());
  const size_t sparse_count = target_accessor(document, 0)["sparse"]["count"].get<size_t>();
  ASSERT_TRUE(encode(document, options_of(true)));
  for (const bool decoded : {false, true}) {
    if (decoded) must(decode(document));
    EXPECT_EQ(morphs_by_position(document), before);
    EXPECT_EQ(target_accessor(document, 0)["sparse"]["count"], sparse_count);
    EXPECT_FALSE(target_accessor(document, 0).contains("bufferView"));
    EXPECT_FALSE(target_accessor(document, 1).contains("sparse"));
    EXPECT_FALSE(target_accessor(document, 2).contains("sparse"));
    EXPECT_FALSE(target_accessor(document, 2).contains("bufferView"));
    // One accessor is still used by both targets.
    EXPECT_EQ(primitive_of(document)["targets"][0], primitive_of(document)["targets"][3]);
    EXPECT_EQ(target_accessor(document, 0)["max"][2].get<float>(), highest);
  }
}

// Zeros without a buffer view cost no bytes in a file.
TEST(MorphTargets, TakeNoMemoryThatTheirPointsDoNotJustify) {
  Document document = document_from_mesh(make_grid(16, 12));
  Json& accessors = document.json()["accessors"];
  accessors.push_back({{"componentType", 5126}, {"type", "VEC3"}, {"count", 80000000}});
  const size_t large = accessors.size() - 1;
  for (int t = 0; t < 50; ++t) primitive_of(document)["targets"].push_back({{"POSITION", large}});
  const auto wrong = encode(document);
  EXPECT_EQ(wrong.status().code(), StatusCode::kInvalidInput);
  EXPECT_TRUE(contains(wrong.status().message(), "80000000 elements for"));
  EXPECT_EQ(read_morph_targets(document, {0, 0}).status().code(), StatusCode::kInvalidInput);
}

TEST(MorphTargets, ASparseTargetThatIsDenseIsWrittenDense) {
  const Mesh mesh = make_grid(8, 8);
  Document document = document_from_mesh(mesh);
  // A sparse accessor that states every element.
  const AccessorData data = make_data(ComponentType::kFloat32, 3, bumps(mesh, 1));
  std::vector<uint8_t> indices, values(data.values.size());
  for (uint32_t i = 0; i < mesh.point_count; ++i) indices.push_back(static_cast<uint8_t>(i));
  std::memcpy(values.data(), data.values.data(), values.size());
  Json accessor = describe_stored(data);
  accessor["sparse"] = {
      {"count", mesh.point_count},
      {"indices", {{"bufferView", append_buffer_view(document, indices)}, {"componentType", 5121}}},
      {"values", {{"bufferView", append_buffer_view(document, values)}}}};
  document.json()["accessors"].push_back(accessor);
  primitive_of(document)["targets"] = Json::array({{{"POSITION", document.json()["accessors"].size() - 1}}});
  const auto before = morphs_by_position(document);
  ASSERT_TRUE(encode(document, options_of(true)));
  EXPECT_FALSE(target_accessor(document, 0).contains("sparse"));
  EXPECT_EQ(morphs_by_position(document), before);
}

TEST(MorphTargets, SparseBeyondEightBitsOfIndices) {
  for (const uint32_t size : {20u, 300u}) {
    const Mesh mesh = make_grid(size, size);
    Document document = document_from_mesh(mesh);
    const std::vector<float> deltas = bumps(mesh, 97);
    const int64_t index = append_sparse(document, deltas);
    const Json& sparse = document.json()["accessors"][static_cast<size_t>(index)]["sparse"];
    EXPECT_EQ(sparse["indices"]["componentType"], size == 20 ? 5123 : 5125);
    EXPECT_EQ(read_accessor(document, index)->values, make_data(ComponentType::kFloat32, 3, deltas).values);
  }
}

TEST(MorphTargets, FollowStockDracoToo) {
  for (const uint32_t holes : {0u, 1u}) {
    Mesh mesh = make_grid(16, 12);
    // Edgebreaker drops or splits these: a degenerate face, an unused point, two fans at one point.
    if (holes == 1) {
      mesh.faces.push_back({3, 3, 4});
      mesh.faces.erase(mesh.faces.begin());
      mesh.faces.erase(mesh.faces.begin() + 40, mesh.faces.begin() + 44);
    }
    Document document = morphing_asset(mesh);
    const auto before = morphs_by_position(document);
    const auto reports = must(encode_document_stock(document, options_of(true), test_pool()));
    EXPECT_EQ(reports[0].skipped, "");
    EXPECT_TRUE(primitive_of(document)["extensions"].contains("KHR_draco_mesh_compression"));
    const auto after = morphs_by_position(document);
    if (holes == 0) {
      EXPECT_EQ(after, before);
    }
    EXPECT_GT(after.size(), mesh.point_count - 10);
    for (const auto& [position, morphs] : after) EXPECT_EQ(morphs, before.find(position)->second);
    EXPECT_TRUE(target_accessor(document, 0).contains("sparse"));
  }
}

TEST(Skins, IntegerWeightsAndJointsStayWhatTheyAre) {
  Mesh mesh = rich_mesh();
  std::vector<uint8_t> bytes;
  std::vector<uint16_t> shorts;
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    const auto a = static_cast<uint8_t>(i % 200), b = static_cast<uint8_t>((255 - a) / 3);
    bytes.insert(bytes.end(), {a, b, static_cast<uint8_t>(255 - a - b), 0});
    shorts.insert(shorts.end(), {static_cast<uint16_t>(i * 7), static_cast<uint16_t>(65535 - i * 7), 0, 0});
  }
  std::erase_if(mesh.attributes, [](const Attribute& a) { return a.semantic.starts_with("WEIGHTS_"); });
  mesh.attributes.push_back(make_attribute("WEIGHTS_0", ComponentType::kUint8, 4, true, bytes));
  mesh.attributes.push_back(make_attribute("WEIGHTS_1", ComponentType::kUint16, 4, true, shorts));
  for (const Compat compat : {Compat::kNone, Compat::kKhr}) {
    Document document = document_from_mesh(mesh);
    EncodeDocumentOptions options = options_of(false);
    options.compat = compat;
    ASSERT_TRUE(encode(document, options));
    const size_t primitives = document.json()["meshes"][0]["primitives"].size();
    EXPECT_EQ(primitives, compat == Compat::kKhr ? 4u : 1u);
    for (size_t p = 0; p < primitives; ++p) {
      const Mesh decoded = must(read(document, 0, p));
      const auto first = values_of<uint8_t>(*decoded.find("WEIGHTS_0"));
      const auto second = values_of<uint16_t>(*decoded.find("WEIGHTS_1"));
      for (size_t i = 0; i < decoded.point_count; ++i) {
        EXPECT_EQ(first[4 * i] + first[4 * i + 1] + first[4 * i + 2] + first[4 * i + 3], 255);
        EXPECT_EQ(second[4 * i] + second[4 * i + 1] + second[4 * i + 2] + second[4 * i + 3], 65535);
      }
      EXPECT_EQ(decoded.find("JOINTS_0")->component_type, ComponentType::kUint8);
      EXPECT_EQ(decoded.find("JOINTS_1")->component_type, ComponentType::kUint16);
    }
  }
}

TEST(Ids, FloatsThatNameThingsAreNotRounded) {
  Mesh mesh = make_grid(12, 12);
  std::vector<float> ids, heights, others;
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    ids.push_back(static_cast<float>(i * 1001 % 65521));
    heights.push_back(std::sqrt(static_cast<float>(i)));
    others.push_back(std::sqrt(static_cast<float>(i)));
  }
  const auto add = [&](const char* semantic, const std::vector<float>& values) {
    mesh.attributes.push_back(make_attribute(semantic, ComponentType::kFloat32, 1, false, values));
  };
  add("_FEATURE_ID_0", ids);
  add("_BATCHID", ids);
  add("_HEIGHT", heights);
  add("_OTHER", others);
  Document document = document_from_mesh(mesh);
  const Json metadata = Json::parse(R"({"schema":{"id":"s"},
    "propertyAttributes":[{"class":"c","properties":{"height":{"attribute":"_HEIGHT"}}}]})");
  document.json()["extensions"]["EXT_structural_metadata"] = metadata;
  primitive_of(document)["extensions"] = Json::parse(R"({"EXT_structural_metadata":{"propertyAttributes":[0]},
    "EXT_mesh_features":{"featureIds":[{"featureCount":65521,"attribute":0}]}})");
  ASSERT_TRUE(encode(document, options_of(false)));
  EXPECT_EQ(document.json()["extensions"]["EXT_structural_metadata"], metadata);
  EXPECT_TRUE(primitive_of(document)["extensions"].contains("EXT_mesh_features"));
  const Mesh decoded = must(read(document));
  const auto sorted = [](const Mesh& of, const char* semantic) {
    std::vector<float> values = values_of<float>(*of.find(semantic));
    std::sort(values.begin(), values.end());
    return values;
  };
  for (const char* semantic : {"_FEATURE_ID_0", "_BATCHID", "_HEIGHT"})
    EXPECT_EQ(sorted(decoded, semantic), sorted(mesh, semantic)) << semantic;
  EXPECT_NE(sorted(decoded, "_OTHER"), sorted(mesh, "_OTHER"));
}

TEST(Manifold, IsDroppedWithAWarningAndItsAccessorsGo) {
  Document document = document_from_mesh(make_grid(5, 5));
  const size_t accessor_count = document.json()["accessors"].size();
  const auto indices = [&](const std::vector<uint32_t>& values) {
    return append_accessor(document, make_data(ComponentType::kUint32, 1, values), 34963, false);
  };
  Json manifold = {{"manifoldPrimitive", {{"indices", indices({0, 1, 2})}, {"attributes", {{"POSITION", 0}}}}},
                   {"mergeIndices", indices({0})},
                   {"mergeValues", indices({1})}};
  document.json()["meshes"][0]["extensions"]["EXT_mesh_manifold"] = manifold;
  document.json()["extensionsUsed"] = Json::array({"EXT_mesh_manifold"});
  const auto reports = must(encode(document));
  EXPECT_EQ(reports[0].skipped, "");
  ASSERT_EQ(reports[0].warnings.size(), 1u);
  EXPECT_TRUE(contains(reports[0].warnings[0], "EXT_mesh_manifold is dropped"));
  EXPECT_EQ(count_in(document, "EXT_mesh_manifold"), 0u);
  EXPECT_EQ(document.json()["accessors"].size(), accessor_count);
  EXPECT_EQ(document.json()["bufferViews"].size(), 1u);
}

TEST(Instances, TheirAttributesAreUntouched) {
  Document document = document_from_mesh(make_grid(5, 5));
  // The positions of the instances and of the points are the same accessor.
  const int64_t position = primitive_of(document)["attributes"]["POSITION"].get<int64_t>();
  const AccessorData before = *read_accessor(document, position);
  document.json()["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] = {
      {"attributes", {{"TRANSLATION", position}}}};
  document.json()["nodes"].push_back({{"mesh", 0}, {"scale", {2, 2, 2}}});
  ASSERT_TRUE(encode(document));
  const Json& instances = document.json()["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  EXPECT_EQ(read_accessor(document, instances["TRANSLATION"].get<int64_t>())->values, before.values);
  ASSERT_TRUE(decode(document).ok());
  EXPECT_EQ(
      read_accessor(
          document,
          document.json()["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"]
              .get<int64_t>())
          ->values,
      before.values);
}

// KHR_mesh_quantization: integer positions, normals and texture coordinates, interleaved in one view.
TEST(Quantization, InterleavedIntegersComeBackExactly) {
  const Mesh grid = make_grid(9, 7);
  std::vector<int16_t> positions;
  std::vector<int8_t> normals;
  std::vector<uint16_t> texcoords;
  std::vector<uint8_t> interleaved;
  for (uint32_t i = 0; i < grid.point_count; ++i) {
    const std::array<int16_t, 3> p = {static_cast<int16_t>(i % 10 * 300 - 1500),
                                      static_cast<int16_t>(i / 10 * 411), static_cast<int16_t>(i * 37 % 501)};
    const std::array<int8_t, 3> n = {static_cast<int8_t>(i % 100), 0, static_cast<int8_t>(127 - i % 100)};
    const std::array<uint16_t, 2> t = {static_cast<uint16_t>(i * 900), static_cast<uint16_t>(65535 - i)};
    positions.insert(positions.end(), p.begin(), p.end());
    normals.insert(normals.end(), n.begin(), n.end());
    texcoords.insert(texcoords.end(), t.begin(), t.end());
    std::array<uint8_t, 16> element{};
    std::memcpy(element.data(), p.data(), 6);
    std::memcpy(element.data() + 8, n.data(), 3);
    std::memcpy(element.data() + 12, t.data(), 4);
    interleaved.insert(interleaved.end(), element.begin(), element.end());
  }
  Mesh expected = grid;
  expected.attributes = {make_attribute("POSITION", ComponentType::kInt16, 3, false, positions),
                         make_attribute("NORMAL", ComponentType::kInt8, 3, true, normals),
                         make_attribute("TEXCOORD_0", ComponentType::kUint16, 2, true, texcoords)};
  Document document = document_from_mesh(expected);
  const int64_t view = append_buffer_view(document, interleaved);
  document.json()["bufferViews"][static_cast<size_t>(view)]["byteStride"] = 16;
  size_t offset = 0;
  for (const char* semantic : {"POSITION", "NORMAL", "TEXCOORD_0"}) {
    accessor_of(document, semantic)["bufferView"] = view;
    accessor_of(document, semantic)["byteOffset"] = offset;
    offset += offset == 0 ? 8 : 4;
  }
  document.json()["extensionsUsed"] = document.json()["extensionsRequired"] =
      Json::array({"KHR_mesh_quantization"});
  ASSERT_EQ(compare_meshes(expected, *read(document)), "");
  for (const Compat compat : {Compat::kNone, Compat::kKhr}) {
    Document copy = document;
    EncodeDocumentOptions options = options_of(false, 1);
    options.compat = compat;
    ASSERT_TRUE(encode(copy, options));
    EXPECT_EQ(compare_meshes(expected, *read(copy)), "");
    ASSERT_TRUE(decode(copy).ok());
    EXPECT_EQ(compare_meshes(expected, *read(copy)), "");
    EXPECT_EQ(copy.json()["extensionsRequired"], Json::array({"KHR_mesh_quantization"}));
  }
}

}  // namespace
}  // namespace psplit
