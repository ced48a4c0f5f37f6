// Whole documents, encoded and decoded: geometry is the same, and data that psplit does not own is unchanged.

#include <algorithm>
#include <functional>
#include <set>

#include "encoder/coding/quantization.h"
#include "gltf_ext/document/extensions.h"
#include "gltf_ext/primitive/read_primitives.h"
#include "psplit/document.h"
#include "tests/gltf_ext/asset.h"

namespace psplit {
namespace {

EncodeDocumentOptions lossless() {
  const EncodeDocumentOptions options = DocumentOptions{.lossless = true};
  return options;
}

// The first difference beyond the default quantization (with `exact`, beyond equality), or an empty string.
std::string difference(Mesh mesh, const Expected<Mesh>& actual, bool exact) {
  if (!actual) return actual.status().to_string();
  std::vector<AttributeCoding> codings;
  std::vector<Tolerance> tolerances;
  for (const Attribute& attribute : mesh.attributes) {
    const bool is_color = attribute.semantic.starts_with("COLOR_");
    const bool coded = !exact && attribute.component_type == ComponentType::kFloat32;
    const bool normal = attribute.semantic == "NORMAL";
    codings.push_back(coded && !normal ? *fit_grid(attribute, attribute.semantic == "POSITION" ? 14
                                                              : is_color                       ? 8
                                                                                               : 12)
                                       : AttributeCoding{});
    tolerances.push_back(
        !coded   ? exact_tolerance()
        : normal ? octahedral_tolerance(10)
                 : grid_tolerance(codings.back().bits, codings.back().origin, codings.back().range));
  }
  round_weights(mesh, codings);
  return compare_meshes(mesh, *actual, tolerances);
}

// Adds primitive 1 with the accessors of primitive 0 and these faces.
void add_primitive_with_faces(Document& document, const std::vector<uint16_t>& indices) {
  Json copy = primitive_of(document);
  copy["indices"] =
      append_accessor(document, make_data<uint16_t>(ComponentType::kUint16, 1, indices), 34963, false);
  document.json()["meshes"][0]["primitives"].push_back(std::move(copy));
}

// The number of positions that both meshes have, equal to the bit.
size_t common_positions(const Expected<Mesh>& a, const Expected<Mesh>& b) {
  std::set<std::array<float, 3>> first;
  size_t common = 0;
  for (const Expected<Mesh>* mesh : {&a, &b}) {
    const std::vector<float> values = values_of<float>(*(*mesh)->find("POSITION"));
    for (size_t i = 0; i < values.size(); i += 3) {
      const std::array<float, 3> position = {values[i], values[i + 1], values[i + 2]};
      if (mesh == &a)
        first.insert(position);
      else
        common += first.count(position);
    }
  }
  return common;
}

TEST(EncodeDocument, EveryAttributeComesBack) {
  const Mesh mesh = rich_mesh();
  for (const bool exact : {false, true})
    for (const uint64_t patches : {1u, 5u})
      for (const Fallback fallback : {Fallback::kNone, Fallback::kUncompressed}) {
        SCOPED_TRACE(std::to_string(exact) + " " + std::to_string(patches));
        Document document = document_from_mesh(mesh);
        const EncodeDocumentOptions options =
            DocumentOptions{.patches = {.count = patches}, .lossless = exact, .fallback = fallback};
        const auto reports = must(encode(document, options));
        ASSERT_EQ(reports.size(), 1u);
        EXPECT_EQ(reports[0].skipped, "");
        EXPECT_EQ(reports[0].faces, mesh.faces.size());
        EXPECT_EQ(reports[0].points, mesh.point_count);
        EXPECT_EQ(reports[0].statistics.patch_count, patches);
        const Expected<Mesh> patched = read(document);
        EXPECT_EQ(difference(mesh, patched, exact), "");
        ASSERT_TRUE(decode(document).ok());
        EXPECT_EQ(count_in(document, kExtensionName), 0u);
        const Mesh plain = must(read(document));
        EXPECT_EQ(plain.faces, patched->faces);
        EXPECT_EQ(compare_meshes(*patched, plain), "");
      }
}

TEST(EncodeDocument, EveryModeComesBack) {
  for (const int mode : {4, 5, 6})
    for (const bool indexed : {true, false}) {
      Document document = document_from_mesh(make_grid(5, 5));
      Json& primitive = primitive_of(document);
      primitive["mode"] = mode;
      if (!indexed) primitive.erase("indices");
      const Expected<Mesh> before = read(document);
      EncodeDocumentOptions options = lossless();
      options.keep_degenerate = true;
      ASSERT_TRUE(encode(document, options).ok());
      EXPECT_EQ(primitive_of(document)["mode"], 4);
      EXPECT_EQ(difference(*before, read(document), true), "") << mode << indexed;
      ASSERT_TRUE(decode(document).ok());
      EXPECT_EQ(difference(*before, read(document), true), "") << mode << indexed;
    }
}

TEST(EncodeDocument, ListsTheExtension) {
  Document without = document_from_mesh(make_grid(3, 3)), with = without;
  ASSERT_TRUE(encode(without).ok());
  EXPECT_EQ(without.json()["extensionsUsed"], Json::array({kExtensionName}));
  EXPECT_EQ(without.json()["extensionsRequired"], Json::array({kExtensionName}));
  EXPECT_EQ(count_in(without, "\"bufferView\""), 1u);
  ASSERT_TRUE(encode(with, DocumentOptions{.fallback = Fallback::kUncompressed}).ok());
  EXPECT_EQ(with.json()["extensionsUsed"], Json::array({kExtensionName}));
  EXPECT_FALSE(with.json().contains("extensionsRequired"));
}

TEST(EncodeDocument, TheFallbackIsWhatThePatchesDecodeTo) {
  Document document = document_from_mesh(rich_mesh());
  ASSERT_TRUE(
      encode(document, DocumentOptions{.patches = {.count = 4}, .fallback = Fallback::kUncompressed}).ok());
  const Expected<Mesh> patched = read(document);
  primitive_of(document).erase("extensions");
  const Expected<Mesh> plain = read(document);
  ASSERT_TRUE(patched.ok() && plain.ok());
  EXPECT_EQ(plain->faces, patched->faces);
  for (size_t i = 0; i < plain->attributes.size(); ++i)
    EXPECT_EQ(plain->attributes[i].values, patched->find(plain->attributes[i].semantic)->values);
}

TEST(EncodeDocument, AccessorsDescribeWhatIsDecoded) {
  Document document = document_from_mesh(rich_mesh());
  // An accessor that had bounds still has them.
  for (const char* name : {"TEXCOORD_0", "indices"}) accessor_of(document, name)["min"] = Json::array({-99});
  accessor_of(document, "TEXCOORD_0")["extras"] = "kept";
  ASSERT_TRUE(encode(document).ok());
  for (const bool decoded : {false, true}) {
    if (decoded) must(decode(document));
    const Mesh mesh = must(read(document));
    for (const Attribute& attribute : mesh.attributes) {
      const Json& accessor = accessor_of(document, attribute.semantic.c_str());
      EXPECT_EQ(accessor["count"], mesh.point_count);
      EXPECT_EQ(accessor["componentType"], static_cast<int>(attribute.component_type));
      EXPECT_EQ(accessor.contains("bufferView"), decoded);
      if (attribute.semantic != "POSITION" && attribute.semantic != "TEXCOORD_0") continue;
      const std::vector<float> values = values_of<float>(attribute);
      for (size_t c = 0; c < attribute.component_count; ++c) {
        float least = values[c], most = values[c];
        for (size_t i = c; i < values.size(); i += attribute.component_count) {
          least = std::min(least, values[i]);
          most = std::max(most, values[i]);
        }
        // The bounds go through JSON text, as in a file.
        EXPECT_EQ(Json::parse(accessor["min"].dump())[c].get<float>(), least);
        EXPECT_EQ(Json::parse(accessor["max"].dump())[c].get<float>(), most);
      }
    }
    EXPECT_EQ(accessor_of(document, "TEXCOORD_0")["extras"], "kept");
    const Json& indices = accessor_of(document, "indices");
    EXPECT_EQ(indices["count"], mesh.faces.size() * 3);
    EXPECT_EQ(indices["min"], Json::array({0}));
    EXPECT_EQ(indices["max"], Json::array({mesh.point_count - 1}));
  }
}

TEST(EncodeDocument, DecodedWeightsSumToOne) {
  Document document = document_from_mesh(rich_mesh());
  EncodeDocumentOptions options;
  for (const int bits : {5, 8, 12}) {
    Document copy = document;
    options.generic_bits = bits;
    ASSERT_TRUE(encode(copy, options).ok());
    const Mesh mesh = must(read(copy));
    const auto first = values_of<float>(*mesh.find("WEIGHTS_0")),
               second = values_of<float>(*mesh.find("WEIGHTS_1"));
    for (size_t point = 0; point < mesh.point_count; ++point) {
      double sum = 0;
      for (size_t c = 0; c < 4; ++c) sum += double{first[4 * point + c]} + double{second[4 * point + c]};
      EXPECT_NEAR(sum, 1, 2e-7) << bits << " bits, point " << point;
    }
  }
}

TEST(EncodeDocument, DecodedColorsAndTangentsStayWithinTheirLimits) {
  Mesh mesh = make_grid(4, 4);
  std::vector<float> color, tangent;
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    const auto t = static_cast<float>(i) / static_cast<float>(mesh.point_count - 1);
    color.insert(color.end(), {t, 2.8e-5f + t * (1 - 2.8e-5f), 0.5f + t / 2});
    tangent.insert(tangent.end(), {i % 2 == 0 ? 1.0000001f : -1.0000001f, 0, 0, i % 3 == 0 ? 1.0f : -1.0f});
  }
  mesh.attributes.push_back(make_attribute("COLOR_0", ComponentType::kFloat32, 3, false, color));
  mesh.attributes.push_back(make_attribute("TANGENT", ComponentType::kFloat32, 4, false, tangent));
  Document document = document_from_mesh(mesh);
  ASSERT_TRUE(encode(document).ok());
  const Mesh decoded = must(read(document));
  for (const float value : values_of<float>(*decoded.find("COLOR_0"))) {
    EXPECT_GE(value, 0.0f);
    EXPECT_LE(value, 1.0f);
  }
  const auto tangents = values_of<float>(*decoded.find("TANGENT"));
  for (size_t i = 3; i < tangents.size(); i += 4) EXPECT_EQ(std::fabs(tangents[i]), 1.0f);
  // With `lossless`, even noise stays.
  Document exact = document_from_mesh(mesh);
  ASSERT_TRUE(encode(exact, lossless()).ok());
  EXPECT_EQ(difference(mesh, read(exact), true), "");
}

TEST(EncodeDocument, LeavesPointsAndLinesAlone) {
  for (const int mode : {0, 1, 2, 3}) {
    Document document = document_from_mesh(make_grid(3, 3));
    Json other = primitive_of(document);
    other["mode"] = mode;
    document.json()["meshes"].push_back(Json{{"primitives", Json::array({other})}});
    const AccessorData positions = *read_accessor(document, 0);
    const auto reports = must(encode(document));
    ASSERT_EQ(reports.size(), 2u);
    EXPECT_EQ(reports[0].skipped, "");
    EXPECT_EQ(reports[1].skipped, "points or lines");
    // They share their accessors with encoded triangles.
    const Json& left = primitive_of(document, 1);
    EXPECT_FALSE(left.contains("extensions"));
    EXPECT_EQ(left["mode"], mode);
    EXPECT_EQ(read_accessor(document, left["attributes"]["POSITION"].get<int64_t>())->values, positions.values);
    EXPECT_EQ(read_accessor(document, left["indices"].get<int64_t>())->count, 54u);
    EXPECT_TRUE(read(document).ok());
  }
}

TEST(EncodeDocument, StoresEqualPrimitivesOnce) {
  Document document = document_from_mesh(rich_mesh());
  Json copy = primitive_of(document);
  copy["material"] = 0;
  document.json()["materials"] = Json::array({Json::object()});
  document.json()["meshes"][0]["primitives"].push_back(copy);
  document.json()["meshes"].push_back(Json{{"primitives", Json::array({copy})}});
  const size_t accessor_count = document.json()["accessors"].size();
  const auto reports = must(encode(document));
  EXPECT_EQ(reports.size(), 3u);
  EXPECT_EQ(document.json()["bufferViews"].size(), 1u);
  EXPECT_EQ(document.json()["accessors"].size(), accessor_count);
  EXPECT_EQ(difference(rich_mesh(), read(document, 0, 1), false), "");
  EXPECT_EQ(difference(rich_mesh(), read(document, 1, 0), false), "");
  EXPECT_EQ(primitive_of(document, 0, 1)["material"], 0);
  ASSERT_TRUE(decode(document).ok());
  EXPECT_EQ(document.json()["accessors"].size(), accessor_count);
  EXPECT_EQ(difference(rich_mesh(), read(document, 1, 0), false), "");
}

// Primitive 1 has the first two faces, primitive 0 all others. No face uses the last point.
Document two_materials() {
  Mesh mesh = rich_mesh();
  std::vector<uint16_t> taken;
  for (size_t i = 0; i < 2; ++i)
    for (const uint32_t point : mesh.faces[i]) taken.push_back(static_cast<uint16_t>(point));
  mesh.faces.erase(mesh.faces.begin(), mesh.faces.begin() + 2);
  std::erase_if(mesh.faces, [&](const auto& face) { return std::count(face.begin(), face.end(), 129u) > 0; });
  Document document = document_from_mesh(mesh);
  add_primitive_with_faces(document, taken);
  return document;
}

Mesh without_points(const Mesh& mesh, const std::function<bool(uint32_t)>& drops) {
  std::vector<uint32_t> number(mesh.point_count, 0), kept;
  for (uint32_t point = 0; point < mesh.point_count; ++point) {
    number[point] = static_cast<uint32_t>(kept.size());
    if (!drops(point)) kept.push_back(point);
  }
  Mesh result = take_points(mesh, kept);
  for (const auto& [a, b, c] : mesh.faces) result.faces.push_back({number[a], number[b], number[c]});
  return result;
}

TEST(EncodeDocument, DividesThePointsOfPrimitivesThatShareAttributes) {
  Document document = two_materials();
  const size_t accessor_count = document.json()["accessors"].size();
  // Of the points 0, 1, 13 and 14, only point 0 is in no other face.
  const Mesh first = without_points(must(read(document)), [](uint32_t point) { return point == 0; });
  const Mesh second = without_points(must(read(document, 0, 1)), [](uint32_t point) {
    return point != 0 && point != 1 && point != 13 && point != 14;
  });
  EncodeDocumentOptions options = lossless();
  options.keep_duplicates = options.keep_unused = true;
  ASSERT_TRUE(encode(document, options).ok());
  EXPECT_NE(primitive_of(document, 0, 0)["attributes"]["POSITION"],
            primitive_of(document, 0, 1)["attributes"]["POSITION"]);
  for (const bool decoded : {false, true}) {
    if (decoded) must(decode(document));
    EXPECT_EQ(difference(first, read(document, 0, 0), true), "");
    EXPECT_EQ(difference(second, read(document, 0, 1), true), "");
  }
  // Nothing remains of the shared accessors.
  EXPECT_EQ(document.json()["accessors"].size(), 2 * (accessor_count - 1));
}

TEST(EncodeDocument, DividedPrimitivesKeepTheirBorderClosed) {
  Document document = two_materials();
  const size_t common = 3;  // points 1, 13 and 14
  ASSERT_TRUE(encode(document, DocumentOptions{.position_bits = 7}).ok());
  EXPECT_EQ(read(document, 0, 1)->point_count, 4u);
  EXPECT_EQ(common_positions(read(document, 0, 0), read(document, 0, 1)), common);
}

TEST(EncodeDocument, DividedPointsTakeTheirMorphTargetsAlong) {
  Document document = document_from_mesh(make_grid(6, 6));
  const AccessorData deltas =
      make_data(ComponentType::kFloat32, 3, values_of<float>(make_grid(6, 6).attributes[0]));
  primitive_of(document)["targets"] =
      Json::array({{{"POSITION", append_accessor(document, deltas, 34962, true)}}});
  add_primitive_with_faces(document, {8, 9, 16});
  ASSERT_TRUE(encode(document, lossless()).ok());
  EXPECT_EQ(read(document, 0, 1)->point_count, 3u);
  for (const size_t primitive : {0u, 1u}) {
    const auto morphs = must(read_morph_targets(document, {0, primitive}));
    EXPECT_EQ(morphs[0].data.values, read(document, 0, primitive)->find("POSITION")->values);
  }
}

TEST(EncodeDocument, OneAccessorMayServeTwoAttributes) {
  Document document = document_from_mesh(rich_mesh());
  Json& attributes = primitive_of(document)["attributes"];
  attributes["TEXCOORD_2"] = attributes["TEXCOORD_0"];
  const Expected<Mesh> before = read(document);
  ASSERT_TRUE(encode(document).ok());
  EXPECT_EQ(difference(*before, read(document), false), "");
  ASSERT_TRUE(decode(document).ok());
  EXPECT_EQ(difference(*before, read(document), false), "");
}

TEST(EncodeDocument, LeavesAccessorsOfOthersAlone) {
  Document document = document_from_mesh(make_grid(4, 4));
  document.json()["nodes"][0]["skin"] = 0;
  document.json()["skins"] = Json::array({{{"joints", {0}}, {"inverseBindMatrices", 0}}});
  const AccessorData before = *read_accessor(document, 0);
  ASSERT_TRUE(encode(document).ok());
  const auto index = document.json()["skins"][0]["inverseBindMatrices"].get<int64_t>();
  EXPECT_EQ(read_accessor(document, index)->values, before.values);
}

TEST(EncodeDocument, NodesAndEverythingElsePassThrough) {
  Document document = document_from_mesh(make_grid(4, 4));
  document.json()["nodes"] =
      Json::parse(R"([{"mesh":0,"name":"a"},{"mesh":0,"translation":[1,2,3]},{"mesh":0}])");
  document.json()["scenes"] = Json::parse(R"([{"nodes":[0,1,2],"extras":{"x":[0.1]}}])");
  document.json()["asset"]["copyright"] = "someone";
  document.json()["extensions"] = Json::parse(R"({"KHR_xmp_json_ld":{"packets":[]}})");
  primitive_of(document)["extras"] = 7;
  primitive_of(document)["extensions"] = Json::parse(R"({"KHR_materials_variants":{"mappings":[]},
    "EXT_mesh_features":{"featureIds":[{"featureCount":2,"attribute":0},{"featureCount":2,"texture":{"index":0}}]}})");
  const Json before = document.json();
  ASSERT_TRUE(encode(document).ok());
  for (const char* name : {"nodes", "scenes", "asset", "extensions"})
    EXPECT_EQ(document.json()[name], before[name]);
  EXPECT_EQ(primitive_of(document)["extras"], 7);
  ASSERT_TRUE(decode(document).ok());
  for (const char* name : {"nodes", "scenes", "asset", "extensions"})
    EXPECT_EQ(document.json()[name], before[name]);
  EXPECT_EQ(primitive_of(document)["extensions"], before["meshes"][0]["primitives"][0]["extensions"]);
}

// A grid with a morph target that doubles every position. Two points differ only in the morph target.
Document morphing() {
  Mesh mesh = make_grid(6, 6);
  const std::vector<float> positions = values_of<float>(mesh.attributes[0]);
  std::vector<float> deltas = positions;
  Document document = document_from_mesh(mesh);
  const int64_t index = append_accessor(document, make_data(ComponentType::kFloat32, 3, deltas), 34962, true);
  const AccessorData colors =
      make_data(ComponentType::kUint8, 4, std::vector<uint8_t>(4 * mesh.point_count, 9), true);
  primitive_of(document)["targets"] =
      Json::array({{{"POSITION", index}},
                   {{"POSITION", index}, {"COLOR_0", append_accessor(document, colors, 34962, false)}}});
  return document;
}

TEST(EncodeDocument, MorphTargetsFollowTheirPoints) {
  for (const Fallback fallback : {Fallback::kNone, Fallback::kUncompressed}) {
    Document document = morphing();
    EncodeDocumentOptions options = lossless();
    options.patches.count = 3;
    options.fallback = fallback;
    ASSERT_TRUE(encode(document, options).ok());
    for (const bool decoded : {false, true}) {
      if (decoded) must(decode(document));
      const Mesh mesh = must(read(document));
      const auto morphs = read_all_targets(document);
      ASSERT_EQ(morphs.size(), 3u);
      for (const MorphAttribute& morph : morphs) {
        if (morph.semantic == "POSITION") {
          EXPECT_EQ(morph.data.values, mesh.find("POSITION")->values);
        }
        EXPECT_EQ(morph.data.count, mesh.point_count);
        EXPECT_EQ(morph.data.normalized, morph.semantic == "COLOR_0");
      }
      const Json& target = primitive_of(document)["targets"][0]["POSITION"];
      EXPECT_EQ(document.json()["accessors"][target.get<size_t>()]["max"], Json({6.0, 6.0, 0.0}));
    }
  }
}

TEST(EncodeDocument, MorphTargetsKeepPointsApart) {
  // Two triangles that differ only in their morph targets.
  const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0};
  Document document = document_from_mesh(make_mesh(positions, {{0, 1, 2}, {3, 4, 5}}));
  std::vector<float> deltas(18, 0);
  deltas[9] = 5;
  primitive_of(document)["targets"] = Json::array(
      {{{"POSITION", append_accessor(document, make_data(ComponentType::kFloat32, 3, deltas), 34962, true)}}});
  const auto reports = must(encode(document, lossless()));
  EXPECT_EQ(reports[0].statistics.merged_points, 2u);
  EXPECT_EQ(read(document)->point_count, 4u);
}

TEST(EncodeDocument, RefusesMorphTargetsOfAnotherLength) {
  Document document = morphing();
  primitive_of(document)["targets"][0]["POSITION"] =
      append_accessor(document, make_data<float>(ComponentType::kFloat32, 3, {0, 0, 0}), 34962, true);
  const Status status = encode(document).status();
  EXPECT_EQ(status.code(), StatusCode::kInvalidInput);
  EXPECT_TRUE(contains(status.to_string(), "mesh 0, primitive 0: morph target POSITION has 1"));
}

TEST(EncodeDocument, KeepsWhatItIsAskedTo) {
  Mesh mesh = make_grid(3, 3);
  mesh.faces.push_back({0, 0, 1});
  std::vector<float> positions = values_of<float>(mesh.attributes[0]);
  // A point that no face uses, and a point with a face that equals point 0.
  positions.insert(positions.end(), {50, 50, 50, 0, 0, 0});
  mesh = make_mesh(positions, mesh.faces);
  mesh.faces.push_back({17, 1, 5});
  const auto counts = [&](bool drop, bool keep_duplicates) {
    Document document = document_from_mesh(mesh);
    EncodeDocumentOptions options = lossless();
    options.keep_degenerate = options.keep_unused = !drop;
    options.keep_duplicates = keep_duplicates;
    EXPECT_TRUE(encode(document, options).ok());
    EXPECT_TRUE(decode(document).ok());
    const Expected<Mesh> decoded = read(document);
    return std::pair(decoded->faces.size(), decoded->point_count);
  };
  EXPECT_EQ(counts(false, true), std::pair(size_t{20}, 18u));
  EXPECT_EQ(counts(false, false), std::pair(size_t{20}, 17u));
  EXPECT_EQ(counts(true, true), std::pair(size_t{19}, 17u));
  EXPECT_EQ(counts(true, false), std::pair(size_t{19}, 16u));
}

// Two strips of a surface that meet in a column of points, each in a mesh of its own.
Document two_halves(bool one_mesh) {
  const auto half = [](float begin, float width) {
    Mesh mesh = make_grid(4, 8);
    std::vector<float> positions = values_of<float>(mesh.attributes[0]);
    for (size_t i = 0; i < positions.size(); i += 3) {
      positions[i] = begin + positions[i] * width;
      positions[i + 1] = std::sqrt(positions[i + 1]);
    }
    return make_mesh(positions, mesh.faces);
  };
  const Mesh left = half(0, 0.25f), right = half(1, 0.7f);
  Document document = document_from_mesh(left);
  const AccessorData positions = make_data(ComponentType::kFloat32, 3, values_of<float>(right.attributes[0]));
  Json primitive = primitive_of(document);
  primitive["attributes"]["POSITION"] = append_accessor(document, positions, 34962, true);
  if (one_mesh)
    document.json()["meshes"][0]["primitives"].push_back(primitive);
  else
    document.json()["meshes"].push_back(Json{{"primitives", Json::array({primitive})}});
  return document;
}

TEST(QuantizationVolume, KeepsBordersClosed) {
  for (const bool one_mesh : {true, false}) {
    const EncodeDocumentOptions options = DocumentOptions{
        .position_bits = 9, .volume = one_mesh ? QuantizationVolume::kMesh : QuantizationVolume::kScene};
    Document document = two_halves(one_mesh);
    ASSERT_TRUE(encode(document, options).ok());
    EXPECT_EQ(common_positions(read(document), one_mesh ? read(document, 0, 1) : read(document, 1, 0)), 9u);
  }
  // With separate grids they do not meet; otherwise the test would show nothing.
  Document document = two_halves(true);
  ASSERT_TRUE(
      encode(document, DocumentOptions{.position_bits = 9, .volume = QuantizationVolume::kPrimitive}).ok());
  EXPECT_LT(common_positions(read(document), read(document, 0, 1)), 9u);
}

TEST(QuantizationVolume, AGeometryOfTwoMeshesJoinsThem) {
  // Mesh 1 has only the left half, mesh 2 has both. Equal primitives are stored once.
  Document document = two_halves(true);
  Json both = document.json()["meshes"][0];
  document.json()["meshes"][0]["primitives"].erase(1);
  document.json()["meshes"].push_back(both);
  ASSERT_TRUE(encode(document, DocumentOptions{.position_bits = 9, .volume = QuantizationVolume::kMesh}).ok());
  EXPECT_EQ(common_positions(read(document, 1, 0), read(document, 1, 1)), 9u);
}

TEST(EncodeDocument, SaysWhyAPrimitiveIsLeftAlone) {
  const auto reason = [](const std::function<void(Document&, Json&)>& change) {
    Document document = document_from_mesh(make_grid(3, 3));
    change(document, primitive_of(document));
    const Json before = document.json();
    const auto reports = encode(document);
    if (!reports) return reports.status().to_string();
    for (const char* name : {"meshes", "accessors"}) EXPECT_EQ(document.json()[name], before[name]);
    return (*reports)[0].skipped;
  };
  EXPECT_EQ(reason([](Document&, Json& primitive) { primitive["attributes"].erase("POSITION"); }),
            "no POSITION");
  EXPECT_EQ(reason([](Document&, Json& primitive) {
              primitive["attributes"]["_P"] = primitive["attributes"]["POSITION"];
              primitive["attributes"].erase("POSITION");
            }),
            "no POSITION");
  EXPECT_EQ(reason([](Document& document, Json& primitive) {
              const AccessorData none{ComponentType::kUint16, 1, false, 0, {}};
              primitive["indices"] = append_accessor(document, none, 34963, false);
            }),
            "no triangles");
  EXPECT_EQ(reason([](Document& document, Json& primitive) {
              primitive["attributes"]["_ID"] = append_accessor(
                  document, make_data(ComponentType::kUint32, 1, std::vector<uint32_t>(16, 70000)), 34962,
                  false);
            }),
            "_ID holds 32-bit integers");
  EXPECT_EQ(
      reason([](Document& document, Json& primitive) {
        primitive["attributes"]["_PAIR"] = document.json()["accessors"].size();
        document.json()["accessors"].push_back({{"componentType", 5120}, {"type", "MAT2"}, {"count", 16}});
      }),
      "_PAIR is a matrix with padding");
  EXPECT_NE(reason([](Document& document, Json&) { document.buffers[0] = {}; }).find("without a uri"),
            std::string::npos);
  // These extensions refer to faces or points by index.
  for (const char* extension : {R"({"CESIUM_primitive_outline":{"indices":1}})", R"({"FB_ngon_encoding":{}})",
                                R"({"EXT_mesh_features":{"featureIds":[{"featureCount":16}]}})"})
    EXPECT_NE(reason([&](Document&, Json& primitive) {
                primitive["extensions"] = Json::parse(extension);
              }).find("depends on the order"),
              std::string::npos)
        << extension;
}

TEST(EncodeDocument, ExtensionsThatDependOnFacesCanBeDropped) {
  Document document = document_from_mesh(make_grid(9, 9));
  const size_t accessor_count = document.json()["accessors"].size();
  const int64_t outline = append_accessor(
      document, make_data(ComponentType::kUint16, 1, std::vector<uint16_t>{0, 1, 1, 2}), 0, false);
  const Json extensions{{"FB_ngon_encoding", Json::object()},
                        {"CESIUM_primitive_outline", {{"indices", outline}}}};
  primitive_of(document)["extensions"] = extensions;
  document.json()["meshes"][0]["extras"]["extensions"]["FB_ngon_encoding"] = 1;
  document.json()["nodes"][0]["extensions"] = {{"FB_ngon_encoding", Json::object()},
                                               {"KHR_node_visibility", {{"a", 1}}}};
  document.json()["extensionsUsed"] = {"CESIUM_primitive_outline", "FB_ngon_encoding", "KHR_node_visibility",
                                       "LISTED"};
  document.json()["extensionsRequired"] = {"FB_ngon_encoding"};
  Document kept = document;
  const auto reports = must(encode(kept));
  EXPECT_TRUE(contains(reports[0].skipped, "--drop-extension CESIUM_primitive_outline"));

  EXPECT_EQ(drop_extension(document, "NONE"), std::nullopt);
  EXPECT_EQ(drop_extension(document, "LISTED"), 0u);
  EXPECT_EQ(drop_extension(document, "FB_ngon_encoding"), 2u);
  EXPECT_EQ(drop_extension(document, "CESIUM_primitive_outline"), 1u);
  EXPECT_FALSE(primitive_of(document).contains("extensions"));
  EXPECT_EQ(document.json()["nodes"][0]["extensions"], Json::parse(R"({"KHR_node_visibility":{"a":1}})"));
  EXPECT_EQ(document.json()["extensionsUsed"], Json::parse(R"(["KHR_node_visibility"])"));
  EXPECT_FALSE(document.json().contains("extensionsRequired"));
  EXPECT_TRUE(document.json()["meshes"][0]["extras"]["extensions"].contains("FB_ngon_encoding"));
  document.json()["nodes"][0].erase("extensions");
  ASSERT_TRUE(encode(document).ok());
  EXPECT_EQ(document.json()["accessors"].size(), accessor_count) << "the outline is gone";
  EXPECT_EQ(read(document)->faces.size(), 162u);
}

TEST(EncodeDocument, APrimitiveThatWouldBeDroppedWholeStays) {
  Document document = document_from_mesh(make_grid(3, 3));
  add_primitive_with_faces(document, {0, 0, 1, 2, 3, 2});
  const auto reports = must(encode(document));
  EXPECT_EQ(reports[0].skipped, "");
  EXPECT_EQ(reports[1].skipped, "no triangles but degenerate ones");
  EXPECT_EQ(read(document, 0, 1)->faces.size(), 2u);
}

TEST(EncodeDocument, APrimitiveInPatchesStays) {
  Document document = document_from_mesh(make_grid(4, 4));
  ASSERT_TRUE(encode(document).ok());
  const Json before = document.json();
  const auto reports = must(encode(document));
  EXPECT_EQ(reports[0].skipped, "already in patches");
  EXPECT_EQ(document.json(), before);
}

TEST(StockDraco, IsWrittenAndReadAgain) {
  const Mesh mesh = rich_mesh();
  Document document = document_from_mesh(mesh);
  ASSERT_TRUE(encode(document).ok());
  const Expected<Mesh> patched = read(document);
  ASSERT_TRUE(decode(document).ok());
  ASSERT_TRUE(encode_document_stock(document, {}, test_pool()));
  EXPECT_EQ(document.json()["extensionsRequired"], Json::array({"KHR_draco_mesh_compression"}));
  EXPECT_EQ(count_in(document, kExtensionName), 0u);
  EXPECT_EQ(document.json()["bufferViews"].size(), 1u);
  EXPECT_EQ(difference(mesh, read(document), false), "");
  // Also from stock Draco to patches.
  const Expected<Mesh> stock = read(document);
  ASSERT_TRUE(encode(document, lossless()).ok());
  EXPECT_EQ(count_in(document, "KHR_draco_mesh_compression"), 0u);
  EXPECT_EQ(document.json()["bufferViews"].size(), 1u);
  EXPECT_EQ(difference(*stock, read(document), true), "");
}

// The points of many faces fall on one place of a coarse grid. Edgebreaker drops faces that repeat a vertex.
TEST(StockDraco, KeepsFacesThatAGridCollapses) {
  const Mesh mesh = rich_mesh(20, 20);
  Document document = document_from_mesh(mesh);
  ASSERT_TRUE(encode(document, DocumentOptions{.position_bits = 3}).ok());
  ASSERT_TRUE(decode(document).ok());
  ASSERT_EQ(read(document)->faces.size(), mesh.faces.size());
  ASSERT_TRUE(encode_document_stock(document, {}, test_pool()));
  EXPECT_EQ(read(document)->faces.size(), mesh.faces.size());
}

TEST(StockDraco, CountsWhatOneStreamCannotHold) {
  Mesh mesh = make_grid(6, 6);
  mesh.faces.push_back({3, 3, 4});
  mesh.attributes[0].values.resize(++mesh.point_count * size_t{12});
  Document document = document_from_mesh(mesh);
  const auto reports = must(encode_document_stock(document, {}, test_pool()));
  EXPECT_EQ(reports[0].statistics.dropped_faces, 1u);
  EXPECT_EQ(reports[0].statistics.dropped_points, 1u);
  EXPECT_EQ(read(document)->faces.size(), mesh.faces.size() - 1);
}

TEST(DecodeDocument, PlainDocumentsPassThrough) {
  Document document = document_from_mesh(rich_mesh());
  const Json before = document.json();
  ASSERT_TRUE(decode(document).ok());
  EXPECT_EQ(document.json(), before);
}

}  // namespace
}  // namespace psplit
