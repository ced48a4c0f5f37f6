// Coarse primitives, for loaders without the extension.
#include <algorithm>
#include <map>
#include <random>

#include "gltf_ext/convert/coarse_primitives.h"
#include "gltf_ext/convert/condense_document.h"
#include "gltf_ext/document/pack_buffers.h"
#include "gltf_ext/json/mesh_primitives.h"
#include "gltf_ext/primitive/primitive_edit.h"
#include "psplit/document.h"
#include "psplit/gltf.h"
#include "system/files.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

EncodeDocumentOptions coarse_options(double share = 0.05) {
  EncodeDocumentOptions options;
  options.patches.count = 4;
  options.fallback = Fallback::kCoarse;
  options.coarse_share = share;
  return options;
}

std::vector<PrimitiveReport> encode_coarse(Document& document,
                                           const EncodeDocumentOptions& options = coarse_options()) {
  return must(encode_document(document, options, draco_backend(), test_pool()));
}

Document encoded(const Mesh& mesh, const EncodeDocumentOptions& options = coarse_options()) {
  Document document = document_from_mesh(mesh);
  encode_coarse(document, options);
  return document;
}

// What a loader without the extension sees.
Document shown(const Document& document) {
  Document copy = document;
  must(exchange_primitives(copy.json()));
  for (Json& mesh : copy.json()["meshes"])
    if (Json* extensions = object_field(mesh, "extensions")) extensions->erase(kExtensionName);
  return copy;
}

// The bits of all values of each point, morph targets too.
std::vector<std::string> points_of(const Document& document, PrimitiveId id) {
  const Mesh mesh = must(read_primitive(document, id, draco_backend(), test_pool()));
  std::vector<std::string> points(mesh.point_count);
  const auto add = [&](const Array<std::byte>& values) {
    const size_t width = values.size() / points.size();
    for (size_t i = 0; i < points.size(); ++i)
      points[i].append(reinterpret_cast<const char*>(values.data()) + i * width, width);
  };
  for (const Attribute& attribute : mesh.attributes) add(attribute.values);
  for (const MorphAttribute& morph : must(read_morph_targets(document, id, mesh.point_count)))
    add(morph.data.values);
  return points;
}

// Morph targets that move each point in another way.
void add_targets(Document& document, size_t mesh) {
  const auto count = accessor_of(document, "POSITION", mesh)["count"].get<uint32_t>();
  for (int target = 0; target < 2; ++target) {
    std::vector<float> moves;
    for (uint32_t i = 0; i < 3 * count; ++i)
      moves.push_back((static_cast<float>(i) + static_cast<float>(target)) / 7);
    primitive_of(document, mesh)["targets"].push_back(
        {{"POSITION", append_accessor(document, make_data(ComponentType::kFloat32, 3, moves), 34962, true)}});
  }
  document.json()["meshes"][mesh]["weights"] = {0.5, 0.25};
}

// A mesh of stock Draco that is small, and would grow as patches, is in patches all the same: else a viewer
// that knows Draco would show its coarse form.
TEST(Coarse, StockDracoIsInPatchesOrShownAsItIs) {
  Document document = document_from_mesh(rich_mesh(12, 10));
  EncodeDocumentOptions stock;
  stock.compat = Compat::kKhr;
  must(encode_document(document, stock, draco_backend(), test_pool()));
  ASSERT_EQ(document.records().primitive({0, 0}).storage(), PrimitiveStorage::kStockDraco);
  const Document before = document;
  EncodeDocumentOptions options = coarse_options();
  options.patches.count = 0;
  encode_coarse(document, options);
  EXPECT_EQ(findings_of(document, draco_backend()), "");
  EXPECT_EQ(document.records().primitive({0, 0}).storage(), PrimitiveStorage::kPatches);
  EXPECT_EQ(points_of(document, {0, 0}).size(), points_of(before, {0, 0}).size());
  // Without patches there is nothing to replace.
  Document alone = before;
  must(add_coarse_primitives(alone, 0.05, draco_backend(), test_pool()));
  EXPECT_EQ(other_primitives(alone.json()["meshes"][0]), nullptr);
  EXPECT_EQ(alone.json()["meshes"], before.json()["meshes"]);
}

TEST(Coarse, TheDecodedAssetIsThatWithoutCoarsePrimitives) {
  for (const bool condense : {false, true}) {
    EncodeDocumentOptions options = coarse_options(), none = options;
    options.condense = none.condense = condense ? Condense::kFast : Condense::kNo;
    none.fallback = Fallback::kNone;
    Document expected = document_from_mesh(rich_mesh(60, 50)), actual = expected;
    add_targets(expected, 0);
    add_targets(actual, 0);
    encode_coarse(expected, none);
    encode_coarse(actual, options);
    EXPECT_EQ(findings_of(actual, draco_backend()), "");
    EXPECT_FALSE(actual.json().contains("extensionsRequired"));
    EXPECT_TRUE(expected.json().contains("extensionsRequired"));
    must(decode(expected));
    must(decode(actual));
    for (const char* member : {"meshes", "accessors", "extensionsUsed"})
      EXPECT_EQ(actual.json().value(member, Json()), expected.json().value(member, Json())) << member;
    EXPECT_EQ(compare_meshes(must(read(expected)), must(read(actual))), "");
  }
}

TEST(Coarse, FilesHaveTheCoarsePrimitivesFirst) {
  const TestFolder folder;
  const Document document = encoded(rich_mesh(80, 60));
  for (const char* name : {"asset.glb", "asset.gltf"}) {
    must(write_document(document, folder / name));
    Document read = must(read_document(folder / name));
    EXPECT_EQ(read.json()["meshes"].dump(), document.json()["meshes"].dump());
    EXPECT_EQ(findings_of(read, draco_backend()), "");
    const Document plain = shown(read);
    EXPECT_EQ(count_in(plain, kExtensionName), 1u);  // in extensionsUsed
    const Mesh coarse = must(psplit::read(plain));
    EXPECT_LE(coarse.faces.size(), 2 * 480u);
    EXPECT_GE(coarse.faces.size(), 100u);
    EXPECT_EQ(coarse_counts(read).faces, coarse.faces.size());
    EXPECT_EQ(coarse_counts(read).points, coarse.point_count);
    EXPECT_GE(coarse_counts(read).bytes, coarse.faces.size() * 6);
  }
}

// So each loader fetches what it shows.
TEST(Coarse, AGltfHasThemInABufferOfTheirOwn) {
  const PackedDocument packed = pack_buffers(encoded(rich_mesh(80, 60)), true);
  const Json& mesh = packed.json["meshes"][0];
  const auto buffer_of = [&](const Json& accessor) {
    const Json& view = packed.json["accessors"][accessor.get<size_t>()]["bufferView"];
    return packed.json["bufferViews"][view.get<size_t>()]["buffer"];
  };
  const Json& coarse = mesh["primitives"][0];
  EXPECT_EQ(buffer_of(coarse["indices"]), 1);
  for (const Json& accessor : coarse["attributes"]) EXPECT_EQ(buffer_of(accessor), 1);
  const Json& patches = mesh["extensions"][kExtensionName]["primitives"][0]["extensions"][kExtensionName];
  EXPECT_EQ(packed.json["bufferViews"][patches["bufferView"].get<size_t>()]["buffer"], 0);
  EXPECT_GT(packed.fallback.size(), 100u * 6);
}

TEST(Coarse, PointsHaveAllAttributesAndMorphTargetsOfFineOnes) {
  Document document = document_from_mesh(rich_mesh(60, 50));
  add_targets(document, 0);
  encode_coarse(document);
  std::vector<std::string> fine = points_of(document, {0, 0}), coarse = points_of(shown(document), {0, 0});
  std::ranges::sort(fine);
  std::ranges::sort(coarse);
  EXPECT_LT(coarse.size(), fine.size() / 4);
  EXPECT_TRUE(std::ranges::includes(fine, coarse));
  EXPECT_EQ(document.json()["meshes"][0]["weights"].size(), 2u);
}

// Two sheets that touch in a line, as primitives of one mesh.
Document two_sheets() {
  Document document = document_from_mesh(make_grid(60, 40));
  Mesh second = make_grid(60, 40);
  std::vector<float> positions = values_of<float>(second.attributes[0]);
  float width = 0;
  for (size_t i = 0; i < positions.size(); i += 3) width = std::max(width, positions[i]);
  for (size_t i = 0; i < positions.size(); i += 3) positions[i] += width;
  second.attributes[0] = make_attribute("POSITION", ComponentType::kFloat32, 3, false, positions);
  add_mesh(document, second);
  Json& meshes = document.json()["meshes"];
  meshes[0]["primitives"].push_back(meshes[1]["primitives"][0]);
  meshes.erase(1);
  return document;
}

TEST(Coarse, PrimitivesThatTouchStayJoined) {
  Document document = two_sheets();
  EncodeDocumentOptions options = coarse_options();
  options.lossless = true;
  encode_coarse(document, options);
  const Document plain = shown(document);
  std::array<std::vector<std::pair<float, float>>, 2> lines;
  float width = 0;
  for (size_t p = 0; p < 2; ++p) {
    const Mesh mesh = must(read(plain, 0, p));
    const std::vector<float> positions = values_of<float>(*mesh.find("POSITION"));
    for (size_t i = 0; p == 0 && i < positions.size(); i += 3) width = std::max(width, positions[i]);
    for (size_t i = 0; i < positions.size(); i += 3)
      if (positions[i] == width) lines[p].emplace_back(positions[i + 1], positions[i + 2]);
    std::ranges::sort(lines[p]);
  }
  EXPECT_GE(lines[0].size(), 2u);
  EXPECT_EQ(lines[0], lines[1]);
}

// Every triangle has points of its own, so no edge of the mesh may collapse.
TEST(Coarse, FacesThatShareNoPointsBecomeFewerToo) {
  const Mesh grid = make_grid(60, 40);
  const std::vector<float> from = values_of<float>(grid.attributes[0]);
  Mesh soup;
  std::vector<float> positions, normals;
  for (const auto& face : grid.faces) {
    const auto first = static_cast<uint32_t>(positions.size() / 3);
    soup.faces.push_back({first, first + 1, first + 2});
    for (const uint32_t point : face) {
      positions.insert(positions.end(), &from[3 * point], &from[3 * point] + 3);
      const float tilt = static_cast<float>(first % 97) / 97;
      normals.insert(normals.end(), {tilt, 0, std::sqrt(1 - tilt * tilt)});
    }
  }
  soup.point_count = static_cast<uint32_t>(positions.size() / 3);
  soup.attributes = {make_attribute("POSITION", ComponentType::kFloat32, 3, false, positions),
                     make_attribute("NORMAL", ComponentType::kFloat32, 3, false, normals)};
  const Document document = encoded(soup);
  EXPECT_LE(must(read(shown(document))).faces.size(), 2 * 240u);
}

TEST(Coarse, WhatIsNotCompressedIsTheSameInBothLists) {
  Document document = two_sheets();
  Json lines = primitive_of(document);
  lines["mode"] = 1;
  document.json()["materials"] = {{{"name", "a"}}, {{"name", "b"}}};
  primitive_of(document, 0, 1)["material"] = 1;
  document.json()["meshes"][0]["primitives"].push_back(lines);
  document.json()["meshes"][0]["extras"] = {{"kept", 1}};
  encode_coarse(document);
  EXPECT_EQ(findings_of(document, draco_backend()), "");
  const Document plain = shown(document);
  EXPECT_EQ(plain.json()["meshes"][0]["primitives"].size(), 3u);
  EXPECT_EQ(primitive_json(plain, {0, 2}), primitive_json(document, {0, 2}));
  EXPECT_EQ(primitive_json(plain, {0, 1})["material"], 1);
  EXPECT_EQ(plain.json()["meshes"][0]["extras"]["kept"], 1);
}

TEST(Coarse, EqualMeshesShareTheData) {
  Document document = document_from_mesh(make_grid(60, 40));
  document.json()["materials"] = {{{"name", "a"}}};
  Json other = document.json()["meshes"][0];
  other["primitives"][0]["material"] = 0;
  document.json()["meshes"].push_back(other);
  encode_coarse(document);
  const Document plain = shown(document);
  EXPECT_EQ(primitive_json(plain, {0, 0})["attributes"], primitive_json(plain, {1, 0})["attributes"]);
  EXPECT_EQ(primitive_json(plain, {0, 0})["indices"], primitive_json(plain, {1, 0})["indices"]);
  EXPECT_EQ(primitive_json(plain, {1, 0})["material"], 0);
  EXPECT_EQ(coarse_counts(document).faces, must(read(plain)).faces.size());
}

TEST(Coarse, SmallPrimitivesStayPlain) {
  Document document = document_from_mesh(make_grid(7, 7));
  const Json before = document.json();
  EncodeDocumentOptions options = coarse_options();
  const auto reports = encode_coarse(document, options);
  EXPECT_TRUE(contains(reports[0].skipped, "coarse"));
  EXPECT_EQ(document.json()["meshes"], before["meshes"]);
  EXPECT_EQ(count_in(document, kExtensionName), 0u);
}

TEST(Coarse, OtherVerbsKeepThem) {
  const Document document = encoded(make_grid(60, 40));
  const std::string expected = shown(document).json()["meshes"].dump();
  const Mesh mesh = must(read(shown(document))), fine = must(read(document));
  const auto check = [&](const Document& changed) {
    EXPECT_EQ(findings_of(changed, draco_backend()), "");
    EXPECT_FALSE(changed.json().contains("extensionsRequired"));
    EXPECT_EQ(compare_meshes(mesh, must(read(shown(changed)))), "");
    EXPECT_EQ(compare_meshes(fine, must(read(changed))), "");
  };
  Document condensed = document;
  must(condense_document(condensed, std::vector<PrimitiveId>{{0, 0}}, {}, test_pool()).status());
  check(condensed);
  must(expand_document(condensed, cpu_backend(), test_pool()).status());
  check(condensed);
  Document again = document;
  EncodeDocumentOptions none;
  must(encode_document(again, none, draco_backend(), test_pool()).status());
  check(again);
  // With another share they are made anew.
  encode_coarse(again, coarse_options(0.2));
  EXPECT_GT(must(read(shown(again))).faces.size(), mesh.faces.size());
  EXPECT_EQ(again.json()["accessors"].size(), document.json()["accessors"].size());
  EXPECT_EQ(findings_of(again, draco_backend()), "");
}

TEST(Coarse, CompatKhrDropsThem) {
  Document document = encoded(make_grid(60, 40));
  EncodeDocumentOptions khr;
  khr.compat = Compat::kKhr;
  khr.patches.count = 2;
  must(encode_document(document, khr, draco_backend(), test_pool()).status());
  EXPECT_EQ(count_in(document, kExtensionName), 0u);
  EXPECT_EQ(document.json()["extensionsRequired"], Json::array({kStockExtensionName}));
  khr.fallback = Fallback::kCoarse;
  EXPECT_EQ(encode_document(document, khr, draco_backend(), test_pool()).status().code(), StatusCode::kUsage);
}

TEST(Coarse, AMeshThatDoesNotFitIntoTheMemoryIsAnError) {
  const TestFolder folder;
  Document document = document_from_mesh(make_grid(60, 40));
  OutOfCoreOptions limits;
  limits.memory = kLeastMemory;
  limits.temporary = folder;
  limits.most_part_faces = 500;
  const Status status =
      encode_document(document, coarse_options(), draco_backend(), test_pool(), {}, limits).status();
  EXPECT_EQ(status.code(), StatusCode::kUnsupported);
  EXPECT_TRUE(contains(status.to_string(), "simplified"));
}

// The text of a file whose JSON `change` has broken.
std::vector<uint8_t> file_with(const Document& document, const std::function<void(Json&)>& change) {
  const TestFolder folder;
  must(write_document(document, folder / "asset.gltf"));
  Json json = Json::parse(must(read_file(folder / "asset.gltf", UINT64_MAX)));
  for (Json& buffer : json["buffers"]) {
    const auto bytes = must(read_file(folder / buffer["uri"].get<std::string>(), UINT64_MAX));
    std::string text;
    for (const uint8_t byte : bytes) {
      constexpr const char* kDigits = "0123456789abcdef";
      text += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
    }
    buffer["uri"] = "data:application/octet-stream," + text;
  }
  change(json);
  const std::string text = json.dump();
  return {text.begin(), text.end()};
}

TEST(Coarse, ReadersSayWhatIsWrong) {
  const Document document = encoded(make_grid(30, 20));
  const auto error_of = [&](const std::function<void(Json&)>& change) {
    Expected<Document> read = parse_document(file_with(document, change), "asset.gltf");
    return read ? findings_of(*read, draco_backend()) : read.status().to_string();
  };
  const auto extension = [](Json& json) -> Json& { return json["meshes"][0]["extensions"][kExtensionName]; };
  EXPECT_EQ(error_of([](Json&) {}), "");
  for (const Json& value :
       {Json(nullptr), Json(1), Json("x"), Json::array(), Json::object(), Json{{"primitives", Json::object()}},
        Json{{"primitives", Json::array()}}, Json{{"primitives", {1}}}})
    EXPECT_TRUE(contains(error_of([&](Json& json) { extension(json) = value; }),
                         "mesh 0: PSPLIT_mesh_draco_patches of a mesh has no list of primitives"));
  for (const Json& value : {Json(nullptr), Json::object(), Json::array(), Json{{"a", 1}}, Json::array({1})})
    EXPECT_TRUE(contains(error_of([&](Json& json) { json["meshes"][0]["primitives"] = value; }),
                         "mesh 0: no list of primitives"));
  const auto coarse = [](Json& json) -> Json& { return json["meshes"][0]["primitives"][0]; };
  EXPECT_TRUE(contains(error_of([&](Json& json) { coarse(json).erase("attributes"); }),
                       "mesh 0: coarse primitive 0: no attributes"));
  EXPECT_TRUE(contains(error_of([&](Json& json) { coarse(json)["indices"] = 1000; }),
                       "names an accessor that does not exist"));
  EXPECT_TRUE(contains(error_of([&](Json& json) { coarse(json)["material"] = 3; }), "materials"));
  EXPECT_TRUE(
      contains(error_of([&](Json& json) { coarse(json)["attributes"]["POSITION"] = coarse(json)["indices"]; }),
               "coarse: POSITION is of type SCALAR"));
  EXPECT_TRUE(contains(error_of([&](Json& json) { coarse(json) = extension(json)["primitives"][0]; }),
                       "coarse: is in patches"));
  EXPECT_TRUE(contains(error_of([&](Json& json) { coarse(json)["targets"] = Json::array({Json::object()}); }),
                       "coarse: 1 morph targets, but the primitives that replace it have 0"));
  EXPECT_TRUE(contains(error_of([&](Json& json) { json.erase("extensionsUsed"); }), "extension-used"));
  EXPECT_TRUE(contains(error_of([&](Json& json) { extension(json)["primitives"][0].erase("attributes"); }),
                       "mesh 0, primitive 0: no attributes"));
}

// Whatever a value in the two lists is, reading and all that is done with what was read ends.
TEST(Coarse, MutantsOfTheListsNeverCrash) {
  const Document document = encoded(make_grid(20, 12));
  std::mt19937 random(1);
  const std::vector<Json> values = {nullptr,       true,          -1, 0, 1, 5, 1000, 0.5, "POSITION",
                                    Json::array(), Json::object()};
  size_t read_count = 0;
  for (int round = 0; round < 300; ++round) {
    const auto change = [&](Json& json) {
      Json* at = &json["meshes"];
      for (int depth = 0; depth < 12 && at->is_structured() && !at->empty(); ++depth) {
        auto member = at->begin();
        std::advance(member, static_cast<std::ptrdiff_t>(random() % at->size()));
        at = &*member;
        if (random() % 5 == 0) break;
      }
      *at = values[random() % values.size()];
    };
    Expected<Document> read = parse_document(file_with(document, change), "asset.gltf");
    if (!read) continue;
    ++read_count;
    static_cast<void>(findings_of(*read, draco_backend()));
    static_cast<void>(coarse_counts(*read));
    Document decoded = *read;
    static_cast<void>(decode(decoded));
    Document again = *read;
    static_cast<void>(encode_document(again, coarse_options(), draco_backend(), test_pool()).status());
  }
  EXPECT_GT(read_count, 20u);
}

}  // namespace
}  // namespace psplit
