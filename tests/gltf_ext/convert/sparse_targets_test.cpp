// Morph targets that become sparse accessors.
#include "gltf_ext/convert/sparse_targets.h"

#include <vector>

#include "gltf_ext/json/json_fields.h"
#include "psplit/document.h"
#include "tests/gltf_ext/asset.h"

namespace psplit {
namespace {

std::vector<float> deltas_of(const Mesh& mesh, uint32_t every, float zero = 0) {
  std::vector<float> deltas(3 * mesh.point_count, zero);
  for (uint32_t i = every / 2; every > 0 && i < mesh.point_count; i += every)
    deltas[3 * i + 1] = 1.0f / 3 + static_cast<float>(i);
  return deltas;
}

// Two meshes of the same points. Each has these targets: few deltas, all deltas, zeros, and zeros as -0.
Document characters() {
  const Mesh mesh = make_grid(16, 12);
  Document document = document_from_mesh(mesh);
  Json second = document.json()["meshes"][0];
  document.json()["meshes"].push_back(std::move(second));
  for (size_t m = 0; m < 2; ++m) {
    Json targets = Json::array();
    for (const std::vector<float>& deltas : {deltas_of(mesh, m == 0 ? 17u : 23u), deltas_of(mesh, 1),
                                             deltas_of(mesh, 0), deltas_of(mesh, 0, -0.0f)})
      targets.push_back({{"POSITION", append_accessor(document, make_data(ComponentType::kFloat32, 3, deltas),
                                                      34962, true)}});
    document.json()["meshes"][m]["primitives"][0]["targets"] = std::move(targets);
  }
  return document;
}

const Json& accessor_of_target(const Document& document, size_t mesh, size_t target,
                               const char* semantic = "POSITION") {
  const Json& primitive = document.json()["meshes"][mesh]["primitives"][0];
  return document.json()["accessors"][primitive["targets"][target][semantic].get<size_t>()];
}

std::vector<Array<std::byte>> all_deltas(const Document& document) {
  std::vector<Array<std::byte>> all;
  for (size_t m = 0; m < document.json()["meshes"].size(); ++m)
    for (const MorphAttribute& morph : must(read_morph_targets(document, {m, 0})))
      all.push_back(morph.data.values);
  return all;
}

TEST(SparseTargets, TakeFewBytesAndHaveTheSameDeltas) {
  for (const ZeroSign sign : {ZeroSign::kIgnored, ZeroSign::kKept}) {
    Document document = characters();
    const auto before = all_deltas(document);
    const uint64_t bytes_before = glb_bytes(document);
    make_targets_sparse(document, sign);
    EXPECT_TRUE(document.check().ok());
    EXPECT_LT(glb_bytes(document), bytes_before);
    auto after = all_deltas(document);
    ASSERT_EQ(after.size(), before.size());
    for (size_t i = 0; i < after.size(); ++i) {
      const bool had_signs = i % 4 == 3;
      const bool is_equal = after[i] == before[had_signs && sign == ZeroSign::kIgnored ? i - 1 : i];
      EXPECT_TRUE(is_equal) << i;
    }
    for (const size_t mesh : {0u, 1u}) {
      EXPECT_TRUE(accessor_of_target(document, mesh, 0).contains("sparse"));
      EXPECT_FALSE(accessor_of_target(document, mesh, 0).contains("bufferView"));
      EXPECT_TRUE(accessor_of_target(document, mesh, 1).contains("bufferView"));
      EXPECT_FALSE(accessor_of_target(document, mesh, 1).contains("sparse"));
      EXPECT_FALSE(accessor_of_target(document, mesh, 2).contains("bufferView"));
      EXPECT_FALSE(accessor_of_target(document, mesh, 2).contains("sparse"));
      EXPECT_EQ(accessor_of_target(document, mesh, 3).contains("bufferView"), sign == ZeroSign::kKept);
      EXPECT_EQ(accessor_of_target(document, mesh, 2)["max"], Json::array({0, 0, 0}));
    }
  }
}

TEST(SparseTargets, ShareViewsAndAccessors) {
  Document document = characters();
  const auto before = document.json()["accessors"].size();
  make_targets_sparse(document, ZeroSign::kIgnored);
  const auto target = [&](size_t mesh, size_t target) {
    return document.json()["meshes"][mesh]["primitives"][0]["targets"][target]["POSITION"].get<size_t>();
  };
  EXPECT_EQ(target(0, 1), target(1, 1));  // equal deltas
  EXPECT_EQ(target(0, 2), target(1, 3));  // zeros
  EXPECT_NE(target(0, 0), target(1, 0));
  EXPECT_EQ(document.json()["accessors"].size(), before - 4);
  // The mesh has its two views; the targets have one each for indices, values and dense deltas.
  const AssetRecords& records = document.records();
  std::set<int64_t> views;
  for (const AccessorRecord& accessor : records.accessors) {
    views.insert(accessor.elements.view);
    if (!accessor.sparse) continue;
    views.insert(accessor.sparse->indices.view);
    views.insert(accessor.sparse->values.view);
  }
  EXPECT_EQ(records.views.size(), 5u);
  EXPECT_EQ(views.size(), 6u);  // with -1, of zeros
}

// Small integers, as of KHR_mesh_quantization, in strides of glTF; normals, tangents and colours.
TEST(SparseTargets, OfAllTypes) {
  const Mesh mesh = make_grid(20, 20);
  Document document = document_from_mesh(mesh);
  std::vector<int16_t> positions(3 * mesh.point_count, 0);
  std::vector<int8_t> normals(3 * mesh.point_count, 0);
  std::vector<uint8_t> colors(4 * mesh.point_count, 0);
  for (uint32_t i = 5; i < mesh.point_count; i += 40) {
    positions[3 * i] = static_cast<int16_t>(-300 - static_cast<int>(i));
    normals[3 * i + 2] = -128;
    colors[4 * i + 3] = 128;
  }
  const auto append = [&](ComponentType type, uint8_t count, const auto& values) {
    return append_accessor(document, make_data(type, count, values), 34962, true);
  };
  primitive_of(document)["targets"] = Json::array({{{"POSITION", append(ComponentType::kInt16, 3, positions)},
                                                    {"NORMAL", append(ComponentType::kInt8, 3, normals)},
                                                    {"COLOR_0", append(ComponentType::kUint8, 4, colors)}}});
  const auto before = all_deltas(document);
  make_targets_sparse(document, ZeroSign::kIgnored);
  EXPECT_TRUE(all_deltas(document) == before);
  for (const char* semantic : {"POSITION", "NORMAL", "COLOR_0"})
    EXPECT_TRUE(accessor_of_target(document, 0, 0, semantic).contains("sparse")) << semantic;
}

TEST(SparseTargets, WhatOthersUseStays) {
  const auto expect_unchanged = [](const char* what, auto&& change) {
    Document document = characters();
    change(document);
    make_targets_sparse(document, ZeroSign::kIgnored);
    EXPECT_TRUE(accessor_of_target(document, 0, 0).contains("bufferView")) << what;
    EXPECT_TRUE(accessor_of_target(document, 1, 0).contains("sparse")) << what;
  };
  const auto target = [](const Document& document) {
    return document.json()["meshes"][0]["primitives"][0]["targets"][0]["POSITION"];
  };
  expect_unchanged("an accessor that is an attribute, too", [&](Document& document) {
    document.json()["meshes"][0]["primitives"][0]["attributes"]["_DELTA"] = target(document);
  });
  expect_unchanged("an accessor that extras may name", [&](Document& document) {
    document.json()["extras"] = {{"accessor", target(document)}};
  });
  expect_unchanged("an accessor in a view of another", [&](Document& document) {
    const Json& accessors = std::as_const(document).json()["accessors"];
    const Json view = accessors[target(document).get<size_t>()]["bufferView"];
    const Json position = document.json()["meshes"][0]["primitives"][0]["attributes"]["POSITION"];
    document.json()["accessors"][position.get<size_t>()]["bufferView"] = view;
  });
  expect_unchanged("an accessor with an unknown extension", [&](Document& document) {
    const Json index = target(document);
    document.json()["accessors"][index.get<size_t>()]["extensions"] = {{"VENDOR_data", {{"kind", 1}}}};
  });
}

// A target in a view that stays keeps the other views that it uses, and all their other users.
TEST(SparseTargets, ViewsThatStayKeepTheirUsers) {
  Document document = characters();
  Json& json = document.json();
  const auto index = [&](size_t target) {
    return json["meshes"][0]["primitives"][0]["targets"][target]["POSITION"].get<size_t>();
  };
  // Target 1 has a sparse value over the data of target 0, whose view extras name.
  json["accessors"][index(0)]["bufferView"] = json["accessors"][index(1)]["bufferView"];
  json["accessors"][index(0)]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", json["accessors"][index(2)]["bufferView"]}, {"componentType", 5125}}},
      {"values", {{"bufferView", json["accessors"][index(2)]["bufferView"]}}}};
  json["extras"] = {{"bufferView", json["accessors"][index(1)]["bufferView"]}};
  const auto before = all_deltas(document);
  make_targets_sparse(document, ZeroSign::kIgnored);
  EXPECT_TRUE(document.check().ok());
  auto after = all_deltas(document);
  for (const size_t zeros : {3u, 7u}) after[zeros] = before[zeros];  // of -0
  EXPECT_TRUE(after == before);
  for (const size_t target : {0u, 1u, 2u})
    EXPECT_TRUE(accessor_of_target(document, 0, target).contains("bufferView")) << target;
}

TEST(SparseTargets, AnAssetThatWouldGrowStays) {
  const Mesh mesh = make_grid(2, 2);
  Document document = document_from_mesh(mesh);
  const AccessorData data = make_data(ComponentType::kFloat32, 3, deltas_of(mesh, 1));
  primitive_of(document)["targets"] =
      Json::array({{{"POSITION", append_accessor(document, data, 34962, true)}}});
  const Json before = document.json();
  make_targets_sparse(document, ZeroSign::kIgnored);
  EXPECT_EQ(document.json(), before);
}

TEST(SparseTargets, AreTheDefaultOfEncode) {
  for (const bool lossless : {false, true})
    for (const MorphTargets wanted : {MorphTargets::kKeep, MorphTargets::kSparse, MorphTargets::kAsFits}) {
      Document document = characters();
      EncodeDocumentOptions options;
      EXPECT_EQ(options.morph_targets, MorphTargets::kAsFits);
      options.morph_targets = wanted;
      options.lossless = lossless;
      must(encode_document(document, options, reference_backend(), test_pool()));
      const bool is_sparse = wanted != MorphTargets::kKeep;
      EXPECT_EQ(accessor_of_target(document, 0, 0).contains("sparse"), is_sparse);
      EXPECT_EQ(accessor_of_target(document, 0, 2).contains("bufferView"), !is_sparse);
      EXPECT_EQ(accessor_of_target(document, 0, 3).contains("bufferView"), !is_sparse || lossless);
    }
}

}  // namespace
}  // namespace psplit
