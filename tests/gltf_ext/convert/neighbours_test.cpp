// Surfaces that touch stay together: on the grids of the input, and beside primitives that stay plain.
#include <array>
#include <cstring>
#include <set>

#include "gltf_ext/convert/stated_grids.h"
#include "psplit/decode.h"
#include "psplit/document.h"
#include "tests/gltf_ext/asset.h"
#include "tools/gltf_psplit/diff/compare_assets.h"

namespace psplit {
namespace {

using Positions = std::set<std::array<float, 3>>;

// A wavy sheet, moved along x.
Mesh sheet(float x, uint32_t columns = 40, uint32_t rows = 40) {
  Mesh mesh = make_grid(columns, rows);
  mesh.attributes.resize(1);
  std::vector<float> values;
  for (uint32_t point = 0; point < mesh.point_count; ++point) {
    const auto column = static_cast<float>(point % (columns + 1)),
               row = static_cast<float>(point / (columns + 1));
    values.insert(values.end(), {x + column * 0.0237f, row * 0.0311f, 0.2f * std::sin(row + 0.3f)});
  }
  mesh.attributes[0] = float_attribute("POSITION", 3, values);
  return mesh;
}

// The right edge of a sheet.
float right_of(uint32_t columns = 40) { return static_cast<float>(columns) * 0.0237f; }

Positions positions_of(const Mesh& mesh) {
  Positions positions;
  const std::vector<float> values = values_of<float>(*mesh.find("POSITION"));
  for (size_t i = 0; i < values.size(); i += 3) positions.insert({values[i], values[i + 1], values[i + 2]});
  return positions;
}

size_t shared_count(const Mesh& a, const Mesh& b) {
  const Positions of_a = positions_of(a), of_b = positions_of(b);
  size_t count = 0;
  for (const auto& position : of_a) count += of_b.contains(position);
  return count;
}
size_t shared_count(const Document& document, size_t a, size_t b) {
  return shared_count(must(read(document, 0, a)), must(read(document, 0, b)));
}

// A mesh of several primitives.
Document mesh_of(const std::vector<Mesh>& meshes) {
  Document document = document_from_mesh(meshes[0]);
  for (size_t i = 1; i < meshes.size(); ++i) add_mesh(document, meshes[i]);
  Json& list = document.json()["meshes"];
  for (size_t i = 1; i < meshes.size(); ++i) list[0]["primitives"].push_back(list[i]["primitives"][0]);
  list.erase(list.begin() + 1, list.end());
  return document;
}

void encode_whole(Document& document, const EncodeDocumentOptions& options = {}) {
  must(encode_document(document, options, reference_backend(), test_pool()));
}

// Encodes the document, and returns the warnings.
std::vector<std::string> warnings_of(Document& document, const EncodeDocumentOptions& options = {}) {
  std::vector<std::string> warnings;
  for (const auto& report : must(encode_document(document, options, reference_backend(), test_pool())))
    warnings.insert(warnings.end(), report.warnings.begin(), report.warnings.end());
  return warnings;
}

// The mesh of a document that was encoded on a coarse grid.
Document in_stock_draco(const std::vector<Mesh>& meshes, int bits,
                        QuantizationVolume volume = QuantizationVolume::kMesh) {
  Document document = mesh_of(meshes);
  EncodeDocumentOptions options;
  options.position_bits = bits;
  options.normal_bits = 7;
  options.texcoord_bits = 9;
  options.color_bits = 6;
  options.generic_bits = 10;
  options.volume = volume;
  options.compat = Compat::kKhr;
  encode_whole(document, options);
  EXPECT_TRUE(document.records().primitive({0, 0}).stock);
  return document;
}

std::string compare_to(const Document& a, const Document& b) {
  const auto read_all = [](const Document& document) {
    return must(read_asset_meshes(document, reference_backend(), describe_stream, test_pool()));
  };
  const AssetMeshes of_a = read_all(a), of_b = read_all(b);
  const AssetComparison found = must(compare_assets(of_a, of_b, {}, {test_pool()}));
  return found.same() ? "" : "differs";
}

TEST(Neighbours, StockDracoKeepsTheGridsThatItStates) {
  for (const Mesh& mesh : {rich_mesh(30, 20), sheet(7)})
    for (const int bits : {8, 11, 17}) {
      Document document = in_stock_draco({mesh}, bits);
      const Mesh before = must(read(document));
      for (const bool condense : {false, true}) {
        Document again = document;
        EncodeDocumentOptions options;
        options.condense = condense ? Condense::kFast : Condense::kNo;
        options.patches.count = 3;
        options.patches.always = true;
        const auto reports = must(encode(again, options));
        EXPECT_TRUE(again.records().primitive({0, 0}).patches);
        EXPECT_EQ(reports[0].position_coding.bits, bits);
        EXPECT_EQ(compare_meshes(before, must(read(again))), "") << bits;
      }
      EncodeDocumentOptions options;
      options.position_bits = bits + 1;
      options.given.position = true;
      must(encode(document, options));
      EXPECT_NE(compare_meshes(before, must(read(document))), "");
    }
}

// decode --to draco: values of 12 bits would move on a grid of 14, and values of 20 bits even become coarser.
TEST(Neighbours, StockDracoThatIsDecodedFirstKeepsItsGrid) {
  for (const int bits : {12, 20}) {
    Document document = in_stock_draco({sheet(0)}, bits);
    const Mesh before = must(read(document));
    EncodeDocumentOptions options;
    options.storage = Storage::kOneStream;
    options.stated = all_stated_grids(document, test_pool());
    ASSERT_TRUE(decode(document).ok());
    must(encode_document(document, options, reference_backend(), test_pool()));
    EXPECT_EQ(compare_meshes(before, must(read(document))), "");
    EXPECT_EQ(all_stated_grids(document, test_pool()).begin()->second.at("POSITION").bits, bits);
  }
}

TEST(Neighbours, GridsOfTheirOwnAreKeptInOneMesh) {
  Document document = in_stock_draco({sheet(0), sheet(right_of())}, 12, QuantizationVolume::kPrimitive);
  const Mesh a = must(read(document, 0, 0)), b = must(read(document, 0, 1));
  must(encode(document));
  EXPECT_EQ(compare_meshes(a, must(read(document, 0, 0))), "");
  EXPECT_EQ(compare_meshes(b, must(read(document, 0, 1))), "");
}

// The second primitive is plain, with the values of the first one's decoded edge.
TEST(Neighbours, PlainSurfacesTakeTheGridOfStockDracoBesideThem) {
  for (const bool is_inside : {true, false}) {
    Document document = in_stock_draco({sheet(0)}, 12);
    const Mesh before = must(read(document));
    Mesh beside = before;
    if (!is_inside) append_mesh(beside, sheet(right_of()));
    add_mesh(document, beside);
    Json& list = document.json()["meshes"];
    list[0]["primitives"].push_back(list[1]["primitives"][0]);
    list.erase(1);
    ASSERT_EQ(shared_count(document, 0, 1), before.point_count);
    must(encode(document));
    EXPECT_EQ(shared_count(document, 0, 1), before.point_count) << is_inside;
    EXPECT_EQ(compare_meshes(before, must(read(document))) == "", is_inside);
  }
}

TEST(Neighbours, PlainSurfacesTakeTheGridOfPatchesBesideThem) {
  Document document = document_from_mesh(sheet(0));
  must(encode(document));
  const Mesh before = must(read(document));
  add_mesh(document, before);
  Json& list = document.json()["meshes"];
  list[0]["primitives"].push_back(list[1]["primitives"][0]);
  list.erase(1);
  must(encode(document));
  EXPECT_TRUE(document.records().primitive({0, 1}).patches);
  EXPECT_EQ(compare_meshes(before, must(read(document, 0, 1))), "");
}

// One triangle on the edge of a sheet: Draco would be larger.
Mesh triangle_on_edge() {
  const std::vector<float> edge = values_of<float>(sheet(0).attributes[0]);
  std::vector<float> values;
  for (const size_t point : {41u * 10 + 40, 41u * 11 + 40})
    values.insert(values.end(), edge.begin() + static_cast<std::ptrdiff_t>(3 * point),
                  edge.begin() + static_cast<std::ptrdiff_t>(3 * point + 3));
  values.insert(values.end(), {1.7f, 0.4f, 0.123f});
  return make_mesh(values, {{0, 1, 2}});
}

TEST(Neighbours, WhatStaysPlainMovesWithItsMesh) {
  for (const bool is_interleaved : {false, true}) {
    Document document = mesh_of({sheet(0), triangle_on_edge()});
    if (is_interleaved) {
      // Positions and normals of the triangle in one view.
      std::vector<float> rows;
      const std::vector<float> values = values_of<float>(triangle_on_edge().attributes[0]);
      for (size_t point = 0; point < 3; ++point) {
        rows.insert(rows.end(), values.begin() + static_cast<std::ptrdiff_t>(3 * point),
                    values.begin() + static_cast<std::ptrdiff_t>(3 * point + 3));
        rows.insert(rows.end(), {0, 0, 1});
      }
      const auto view = append_buffer_view(document, {reinterpret_cast<const uint8_t*>(rows.data()), 72});
      document.json()["bufferViews"][static_cast<size_t>(view)]["byteStride"] = 24;
      Json& position = accessor_of(document, "POSITION", 0, 1);
      position["bufferView"] = view;
      position.erase("byteOffset");
      document.json()["accessors"].push_back(
          {{"bufferView", view}, {"byteOffset", 12}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
      primitive_of(document, 0, 1)["attributes"]["NORMAL"] = document.json()["accessors"].size() - 1;
    }
    const Document before = document;
    ASSERT_EQ(shared_count(document, 0, 1), 2u);
    EXPECT_TRUE(warnings_of(document).empty());
    ASSERT_EQ(document.records().primitive({0, 1}).storage(), PrimitiveStorage::kPlain);
    ASSERT_TRUE(document.records().primitive({0, 0}).draco() != nullptr);
    EXPECT_EQ(shared_count(document, 0, 1), 2u);
    EXPECT_NE(must(read(before, 0, 1)).find("POSITION")->values,
              must(read(document, 0, 1)).find("POSITION")->values);
    EXPECT_EQ(findings_of(document, reference_backend()), "");
    EXPECT_EQ(compare_to(before, document), "");
    if (is_interleaved) {
      EXPECT_EQ(must(read(before, 0, 1)).find("NORMAL")->values,
                must(read(document, 0, 1)).find("NORMAL")->values);
    }
  }
}

TEST(Neighbours, LinesAndIntegersAndSharedValuesMoveToo) {
  Mesh numbered = sheet(right_of());
  numbered.attributes.push_back(
      make_attribute("_ID", ComponentType::kUint32, 1, false, std::vector<uint32_t>(numbered.point_count, 3)));
  Document document = mesh_of({sheet(0), numbered, sheet(0)});
  Json& list = document.json()["meshes"];
  list[0]["primitives"][2]["mode"] = 1;  // lines
  // Another mesh has the same points, of which nothing is encoded.
  Json other = list[0]["primitives"][1];
  list.push_back({{"primitives", Json::array({other})}});
  const Mesh apart = must(read(document, 1));
  const size_t touching = shared_count(document, 0, 1);
  ASSERT_EQ(touching, 41u);
  const auto line_points = [&] { return positions_of(must(read_lines_or_points(document, {0, 2})).mesh); };
  EXPECT_TRUE(warnings_of(document).empty());
  ASSERT_EQ(document.records().primitive({0, 1}).storage(), PrimitiveStorage::kPlain);
  EXPECT_EQ(shared_count(document, 0, 1), touching);
  EXPECT_EQ(line_points(), positions_of(must(read(document, 0, 0))));
  EXPECT_EQ(findings_of(document, reference_backend()), "");
  // Values that a mesh without a grid uses, too, are not moved for it.
  EXPECT_EQ(must(read(document, 1)).find("POSITION")->values, apart.find("POSITION")->values);
}

TEST(Neighbours, WhatCannotMoveGetsALine) {
  Document document = in_stock_draco({sheet(0)}, 12);
  // Beyond the grid of the first primitive, which is stored as it is because of an extension.
  add_mesh(document, sheet(right_of()));
  Json& list = document.json()["meshes"];
  list[0]["primitives"].push_back(list[1]["primitives"][0]);
  list[0]["primitives"][0]["extensions"]["FB_ngon_encoding"] = Json::object();
  list.erase(1);
  const std::vector<std::string> warnings = warnings_of(document);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(contains(warnings[0], "surfaces that touch may come apart")) << warnings[0];
}

// Two meshes that nodes move so that they touch.
Document scene_of(const Json& first, const Json& second, float from) {
  Document document = document_from_mesh(sheet(0));
  add_mesh(document, sheet(from));
  Json& json = document.json();
  json["nodes"] = Json::array({first, second, {{"children", {0, 1}}, {"scale", {0.01, 0.01, 0.01}}}});
  json["nodes"][0]["mesh"] = 0;
  json["nodes"][1]["mesh"] = 1;
  json["scenes"] = Json::array({{{"nodes", {2}}}});
  return document;
}

TEST(Neighbours, MeshesOfASceneTouchWhereNodesAllowIt) {
  EncodeDocumentOptions options;
  options.volume = QuantizationVolume::kScene;
  // The edges of the first mesh are 0.948 apart, and the second mesh begins 3.5 before it should.
  const float from = right_of() - 3.5f;
  for (const double y : {0.0, 0.25, -2.0}) {
    Document document = scene_of(Json{{"translation", {1, y, 0}}}, Json{{"translation", {4.5, y, 0}}}, from);
    const auto touching = [&] {
      Mesh second = must(read(document, 1));
      std::vector<float> values = values_of<float>(*second.find("POSITION"));
      for (size_t i = 0; i < values.size(); i += 3) values[i] += 3.5f;
      second.attributes[0] = float_attribute("POSITION", 3, values);
      return shared_count(must(read(document, 0)), second);
    };
    EXPECT_TRUE(warnings_of(document, options).empty());
    EXPECT_EQ(touching(), 41u);
    EXPECT_EQ(findings_of(document, reference_backend()), "");
  }
  for (const auto& [first, second] :
       {std::pair{R"({"translation": [0.1, 0, 0]})", R"({"translation": [0.3, 0, 0]})"},
        {R"({"scale": [2, 2, 2]})", "{}"},
        {"{}", R"({"rotation": [0, 0, 1, 0]})"}}) {
    Document document = scene_of(Json::parse(first), Json::parse(second), from);
    const std::vector<std::string> warnings = warnings_of(document, options);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_TRUE(contains(warnings[0], "surfaces of different meshes that touch may come apart"));
  }
  Document same = scene_of(Json{{"translation", {0.1, 0, 0}}}, Json{{"translation", {0.1, 0, 0}}}, from);
  EXPECT_TRUE(warnings_of(same, options).empty());
}

}  // namespace
}  // namespace psplit
