// Documents whose default grids would make distinct values equal: tests the codings, and the report's
// sentences.
#include <algorithm>
#include <cmath>

#include "encoder/coding/precision_guard.h"
#include "psplit/document.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

// A sheet with texture coordinates in [0, tiles].
Mesh tiled_sheet(float tiles, float left = 0) {
  Mesh mesh = make_grid(60, 60);
  std::vector<float> positions, texture;
  for (uint32_t i = 0; i < mesh.point_count; ++i) {
    const auto x = static_cast<float>(i % 61) / 60, y = static_cast<float>(i / 61) / 60;
    positions.insert(positions.end(), {left + x, y, 0.1f * std::sin(9 * x)});
    texture.insert(texture.end(), {tiles * x, tiles * y});
  }
  mesh.attributes = {make_attribute("POSITION", ComponentType::kFloat32, 3, false, positions),
                     make_attribute("TEXCOORD_0", ComponentType::kFloat32, 2, false, texture)};
  return mesh;
}

// The largest error of the texture coordinates of tiled_sheet, in textures.
double texture_error(const Mesh& decoded, float tiles, float left = 0) {
  const std::vector<float> positions = values_of<float>(*decoded.find("POSITION")),
                           texture = values_of<float>(*decoded.find("TEXCOORD_0"));
  double worst = 0;
  for (size_t i = 0; i < decoded.point_count; ++i)
    for (size_t c = 0; c < 2; ++c) {
      const double place = std::round((double{positions[3 * i + c]} - (c == 0 ? double{left} : 0)) * 60) / 60;
      worst = std::max(worst, std::fabs(place * double{tiles} - double{texture[2 * i + c]}));
    }
  return worst;
}

// The rounding of floats up to 4096 comes to that.
constexpr double kAllowed = kTextureError + 4096.0 / (1 << 23);

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

TEST(GuardedPrecision, TextureCoordinatesOfPrimitivesHaveGridsOfTheirOwn) {
  Document document = document_from_mesh(tiled_sheet(1));
  add_mesh(document, tiled_sheet(4096, 1));
  Json& meshes = document.json()["meshes"];
  meshes[0]["primitives"].push_back(meshes[1]["primitives"][0]);
  meshes.erase(1);
  const auto reports = must(encode(document));
  ASSERT_EQ(reports.size(), 2u);
  EXPECT_LE(texture_error(must(read(document, 0, 0)), 1), 1.0 / 4096);
  EXPECT_LE(texture_error(must(read(document, 0, 1)), 4096, 1), kAllowed);
  EXPECT_TRUE(reports[0].notes.empty()) << joined(reports[0].notes);
  EXPECT_EQ(joined(reports[1].notes).find("TEXCOORD_0 gets "), 0u) << joined(reports[1].notes);
  EXPECT_TRUE(reports[1].warnings.empty()) << joined(reports[1].warnings);
}

TEST(GuardedPrecision, StatedBitsStayAndWarn) {
  for (const bool is_usual : {true, false}) {
    Document document = document_from_mesh(tiled_sheet(4096));
    EncodeDocumentOptions options;
    if (is_usual)
      options.given.texcoord = true;
    else
      options.texcoord_bits = 11;
    const auto reports = must(encode(document, options));
    EXPECT_GT(texture_error(must(read(document)), 4096), 0.3);
    EXPECT_TRUE(reports[0].notes.empty());
    EXPECT_NE(joined(reports[0].warnings).find("as given"), std::string::npos) << joined(reports[0].warnings);
  }
}

TEST(GuardedPrecision, TransformsOfTexturesCount) {
  for (const bool is_variant : {false, true}) {
    Document document = document_from_mesh(tiled_sheet(1));
    document.json()["materials"] = Json::parse(
        R"([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 1,
             "extensions": {"KHR_texture_transform": {"scale": [1, -1000], "texCoord": 0}}}}}])");
    if (is_variant)
      primitive_of(document)["extensions"]["KHR_materials_variants"] = {
          {"mappings", Json::array({{{"material", 0}, {"variants", Json::array({0})}}})}};
    else
      primitive_of(document)["material"] = 0;
    const auto reports = must(encode(document));
    EXPECT_LE(1000 * texture_error(must(read(document)), 1), kTextureError);
    EXPECT_EQ(reports[0].notes.size(), 1u) << joined(reports[0].notes);
  }
}

TEST(GuardedPrecision, BitsChosenByEdgesAreGuardedToo) {
  Mesh mesh = tiled_sheet(1);
  std::vector<float> positions = values_of<float>(mesh.attributes[0]);
  positions[0] = -1e6f;
  mesh.attributes[0] = make_attribute("POSITION", ComponentType::kFloat32, 3, false, positions);
  Document document = document_from_mesh(mesh);
  const auto reports = must(encode(document, DocumentOptions{.position_bits_by_edges = true}));
  EXPECT_EQ(joined(reports[0].notes).find("POSITION is kept exactly"), 0u) << joined(reports[0].notes);
  EXPECT_EQ(must(read(document)).point_count, mesh.point_count);
}

TEST(GuardedPrecision, AnErrorBoundIsGiven) {
  Mesh mesh = tiled_sheet(1);
  Document document = document_from_mesh(mesh);
  const auto reports = must(encode(document, DocumentOptions{.max_position_error = 0.1}));
  EXPECT_TRUE(reports[0].notes.empty());
  EXPECT_NE(joined(reports[0].warnings).find("as given"), std::string::npos) << joined(reports[0].warnings);
}

TEST(GuardedPrecision, PrimitivesThatShareAGridOfPositionsKeepIt) {
  Mesh thin = make_grid(7, 99);
  std::vector<float> positions;
  for (uint32_t i = 0; i < thin.point_count; ++i) {
    const float angle = static_cast<float>(i % 8) * 0.7853982f;
    positions.insert(positions.end(),
                     {10 * static_cast<float>(i / 8), 0.003f * std::cos(angle), 0.003f * std::sin(angle)});
  }
  thin.attributes = {make_attribute("POSITION", ComponentType::kFloat32, 3, false, positions)};
  Document document = document_from_mesh(tiled_sheet(1));
  add_mesh(document, thin);
  Json& meshes = document.json()["meshes"];
  meshes[0]["primitives"].push_back(meshes[1]["primitives"][0]);
  meshes.erase(1);
  const auto reports = must(encode(document));
  EXPECT_EQ(reports[0].position_coding.bits, reports[1].position_coding.bits);
  EXPECT_EQ(reports[0].position_coding.range, reports[1].position_coding.range);
  EXPECT_GT(reports[0].position_coding.bits, 14);
  EXPECT_EQ(reports[1].notes.size(), 1u) << joined(reports[1].notes);
}

TEST(GuardedPrecision, MeshesInPartsAreGuardedToo) {
  const TestFolder folder;
  const OutOfCoreOptions limits{.memory = uint64_t{1} << 30, .temporary = folder, .most_part_faces = 2000};
  Document document = document_from_mesh(tiled_sheet(4096));
  const auto reports = must(encode_document(document, {}, reference_backend(), test_pool(), {}, limits));
  EXPECT_EQ(joined(reports[0].notes).find("TEXCOORD_0 gets "), 0u) << joined(reports[0].notes);
  EXPECT_LE(texture_error(must(read(document)), 4096), kAllowed);
}

}  // namespace
}  // namespace psplit
