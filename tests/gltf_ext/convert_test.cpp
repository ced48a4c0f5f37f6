// Documents through the encoder and back: the same meshes, whatever the primitives look like and whatever is
// asked for.
#include "gltf_ext/convert.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>

#include "gltf_ext/validate.h"
#include "src/cpu/cpu_backend.h"
#include "tests/support/compare_meshes.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

const ThreadPool& pool() {
  static const ThreadPool two(2);
  return two;
}

Mesh read(const Document& document, PrimitiveId id = {}) {
  Expected<Mesh> mesh = read_primitive(document, id, cpu_backend(), pool());
  EXPECT_TRUE(mesh) << mesh.status().to_string();
  return mesh ? std::move(*mesh) : Mesh{};
}

EncodeDocumentOptions exactly(uint64_t patches) {
  EncodeDocumentOptions options;
  options.patches = patches;
  options.lossless = true;
  return options;
}

// Encodes, validates, decodes; every primitive must come back as it was.
void expect_same_after(Document document, const EncodeDocumentOptions& options) {
  std::vector<Mesh> before;
  for (const PrimitiveId id : all_primitives(document)) before.push_back(read(document, id));
  const auto reports = encode_document(document, options, cpu_backend(), pool());
  ASSERT_TRUE(reports) << reports.status().to_string();
  for (const PrimitiveReport& report : *reports) EXPECT_EQ(report.skipped, "");
  for (const Finding& finding : validate_document(document, cpu_backend(), pool()))
    ADD_FAILURE() << finding.rule << ": " << finding.message;
  ASSERT_TRUE(decode_document(document, cpu_backend(), pool()).ok());
  const std::vector<PrimitiveId> after = all_primitives(document);
  ASSERT_EQ(after.size(), before.size());
  for (size_t i = 0; i < after.size(); ++i) EXPECT_EQ(compare_meshes(before[i], read(document, after[i])), "");
}

// A grid with everything that glTF knows at a point.
Mesh loaded_grid(uint32_t side) {
  Mesh mesh = make_grid(side, side);
  const uint32_t n = mesh.point_count;
  const auto series = [&]<typename T>(T, size_t components, uint32_t modulus) {
    std::vector<T> values(n * components);
    for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<T>(i * 7 % modulus);
    return values;
  };
  mesh.attributes.push_back(make_attribute("NORMAL", ComponentType::kFloat32, 3, false, series(0.0f, 3, 2)));
  mesh.attributes.push_back(make_attribute("TANGENT", ComponentType::kFloat32, 4, false, series(0.0f, 4, 2)));
  mesh.attributes.push_back(
      make_attribute("TEXCOORD_0", ComponentType::kFloat32, 2, false, series(0.0f, 2, 100)));
  mesh.attributes.push_back(
      make_attribute("TEXCOORD_1", ComponentType::kUint16, 2, true, series(uint16_t{}, 2, 60000)));
  mesh.attributes.push_back(
      make_attribute("COLOR_0", ComponentType::kUint8, 4, true, series(uint8_t{}, 4, 256)));
  mesh.attributes.push_back(
      make_attribute("JOINTS_0", ComponentType::kUint8, 4, false, series(uint8_t{}, 4, 20)));
  mesh.attributes.push_back(make_attribute("WEIGHTS_0", ComponentType::kFloat32, 4, false, series(0.0f, 4, 2)));
  mesh.attributes.push_back(
      make_attribute("_ID", ComponentType::kUint16, 1, false, series(uint16_t{}, 1, 65535)));
  mesh.attributes.push_back(make_attribute("_SIGNED", ComponentType::kInt8, 3, true, series(int8_t{}, 3, 120)));
  return mesh;
}

TEST(Convert, KeepsEveryKindOfAttribute) { expect_same_after(document_from_mesh(loaded_grid(30)), exactly(5)); }

TEST(Convert, KeepsIndicesOfEveryWidth) {
  for (const uint32_t side : {10u, 100u, 300u})
    expect_same_after(document_from_mesh(make_grid(side, side)), exactly(3));
}

// The same positions as a list, without indices, as a strip and as a fan.
TEST(Convert, TurnsStripsFansAndUnindexedPrimitivesIntoLists) {
  std::vector<float> ring{0, 0, 0};
  for (int i = 0; i <= 40; ++i) {
    const float angle = static_cast<float>(i) * 0.15f;
    ring.insert(ring.end(), {std::cos(angle), std::sin(angle), 0});
  }
  Mesh points = make_mesh(ring, {{0, 1, 2}});
  for (const int mode : {4, 5, 6}) {
    Document document = document_from_mesh(points);
    Json& primitive = document.json["meshes"][0]["primitives"][0];
    primitive.erase("indices");
    primitive["mode"] = mode;
    const Mesh before = read(document);
    EXPECT_EQ(before.faces.size(), mode == 4 ? 14u : 40u);
    ASSERT_TRUE(encode_document(document, exactly(2), cpu_backend(), pool()));
    EXPECT_EQ(document.json["meshes"][0]["primitives"][0].value("mode", 4), 4);
    ASSERT_TRUE(decode_document(document, cpu_backend(), pool()).ok());
    Mesh expected = before;
    // Strips and fans of these points repeat none, so nothing is merged.
    EXPECT_EQ(compare_meshes(expected, read(document)), "") << "mode " << mode;
  }
}

TEST(Convert, LeavesPointsAndLinesAlone) {
  for (const int mode : {0, 1, 2, 3}) {
    Document document = document_from_mesh(make_grid(4, 4));
    document.json["meshes"][0]["primitives"][0]["mode"] = mode;
    const Json before = document.json["meshes"];
    const auto reports = encode_document(document, {}, cpu_backend(), pool());
    ASSERT_TRUE(reports);
    EXPECT_EQ(reports->front().skipped, "points or lines");
    EXPECT_EQ(document.json["meshes"], before);
  }
}

// Two primitives on one set of attributes, each with indices of its own.
TEST(Convert, PrimitivesMayShareAttributes) {
  const Mesh whole = make_grid(20, 20);
  Document document = document_from_mesh(whole);
  AccessorData half{ComponentType::kUint32, 1, false, 300, {}};
  std::vector<uint32_t> indices;
  for (size_t face = 100; face < 200; ++face)
    indices.insert(indices.end(), whole.faces[face].begin(), whole.faces[face].end());
  half.values.resize(indices.size() * sizeof(uint32_t));
  std::memcpy(half.values.data(), indices.data(), half.values.size());
  Json& primitives = document.json["meshes"][0]["primitives"];
  Json second = primitives[0];
  second["indices"] = append_accessor(document, half, 34963, false);
  document.json["meshes"][0]["primitives"].push_back(second);
  EncodeDocumentOptions options = exactly(4);
  options.drop_degenerate = false;
  expect_same_after(document, options);
}

TEST(Convert, OneMeshUsedTwiceIsStoredOnce) {
  Document document = document_from_mesh(make_grid(20, 20));
  document.json["meshes"].push_back(document.json["meshes"][0]);
  document.json["nodes"].push_back({{"mesh", 1}});
  const auto reports = encode_document(document, exactly(4), cpu_backend(), pool());
  ASSERT_TRUE(reports);
  const auto view = [&](size_t mesh) {
    return document.json["meshes"][mesh]["primitives"][0]["extensions"][kExtensionName]["bufferView"];
  };
  EXPECT_EQ(view(0), view(1));
}

// Halves of a grid on either side of a border, each of an extent of its own.
TEST(Convert, OneGridForAMeshKeepsBordersBetweenPrimitivesTogether) {
  std::vector<float> left, right;
  for (int i = 0; i < 20; ++i) {
    const float y = static_cast<float>(i) * 0.313f;
    left.insert(left.end(), {-1, y, 0, 0.1f, y, 0});
    right.insert(right.end(), {0.1f, y, 0, 7.7f, y, 0});
  }
  Faces faces;
  for (uint32_t i = 0; i + 3 < 40; i += 2) {
    faces.push_back({i, i + 1, i + 3});
    faces.push_back({i, i + 3, i + 2});
  }
  const auto border = [](const Mesh& mesh, float side) {
    std::vector<std::array<float, 3>> found;
    for (uint32_t point = 0; point < mesh.point_count; ++point) {
      std::array<float, 3> at{};
      std::memcpy(at.data(), mesh.attributes[0].values.data() + point * sizeof at, sizeof at);
      if (std::fabs(at[0] - side) < 0.05f) found.push_back(at);
    }
    std::sort(found.begin(), found.end());
    return found;
  };
  for (const QuantizationVolume volume : {QuantizationVolume::kPrimitive, QuantizationVolume::kMesh}) {
    Document document = document_from_mesh(make_mesh(left, faces));
    const Document other = document_from_mesh(make_mesh(right, faces));
    const Mesh second = read(other);
    Json primitive = Json::object();
    const Attribute& position = second.attributes[0];
    primitive["attributes"]["POSITION"] = append_accessor(
        document, {position.component_type, 3, false, second.point_count, position.values}, 34962, true);
    primitive["indices"] = document.json["meshes"][0]["primitives"][0]["indices"];
    document.json["meshes"][0]["primitives"].push_back(primitive);
    EncodeDocumentOptions options;
    options.position_bits = 11;
    options.volume = volume;
    ASSERT_TRUE(encode_document(document, options, cpu_backend(), pool()));
    const auto a = border(read(document, {0, 0}), 0.1f), b = border(read(document, {0, 1}), 0.1f);
    ASSERT_EQ(a.size(), 20u);
    EXPECT_EQ(a == b, volume == QuantizationVolume::kMesh);
  }
}

TEST(Convert, TheFallbackIsTheDecodedMesh) {
  Document document = document_from_mesh(loaded_grid(20));
  EncodeDocumentOptions options;
  options.patches = 3;
  options.fallback = Fallback::kUncompressed;
  ASSERT_TRUE(encode_document(document, options, cpu_backend(), pool()));
  EXPECT_FALSE(document.json.contains("extensionsRequired"));
  const Mesh decoded = read(document);
  Json& primitive = document.json["meshes"][0]["primitives"][0];
  primitive.erase("extensions");
  EXPECT_EQ(compare_meshes(decoded, read(document)), "");
}

TEST(Convert, StockDracoHoldsTheSameMesh) {
  Document document = document_from_mesh(loaded_grid(20));
  ASSERT_TRUE(encode_document(document, exactly(4), cpu_backend(), pool()));
  ASSERT_TRUE(decode_document(document, cpu_backend(), pool()).ok());
  const Mesh plain = read(document);
  EncodeDocumentOptions options;
  options.lossless = true;
  ASSERT_TRUE(encode_document_stock(document, options, pool()).ok());
  EXPECT_EQ(document.json["extensionsRequired"], Json::array({"KHR_draco_mesh_compression"}));
  EXPECT_EQ(compare_meshes(plain, read(document)), "");
}

TEST(Convert, DuplicatesAreMergedUnlessTheyAreToBeKept) {
  // A soup: every face has points of its own.
  const Mesh grid = make_grid(10, 10);
  std::vector<float> positions;
  Faces faces;
  for (const auto& face : grid.faces) {
    const auto first = static_cast<uint32_t>(positions.size() / 3);
    for (const uint32_t point : face) {
      std::array<float, 3> at{};
      std::memcpy(at.data(), grid.attributes[0].values.data() + point * sizeof at, sizeof at);
      positions.insert(positions.end(), at.begin(), at.end());
    }
    faces.push_back({first, first + 1, first + 2});
  }
  const Document soup = document_from_mesh(make_mesh(positions, faces));
  for (const bool keep : {false, true}) {
    Document document = soup;
    EncodeDocumentOptions options = exactly(3);
    options.keep_duplicates = keep;
    const auto reports = encode_document(document, options, cpu_backend(), pool());
    ASSERT_TRUE(reports);
    EXPECT_EQ(read(document).point_count, keep ? 600u : 121u);
    EXPECT_EQ(reports->front().statistics.merged_points, keep ? 0u : 479u);
  }
}

TEST(Convert, DegenerateFacesAndUnusedPointsStayUnlessTheyAreToBeDropped) {
  Mesh mesh = make_grid(10, 10);
  mesh.faces.push_back({3, 3, 4});
  mesh.faces.erase(mesh.faces.begin());  // its corner point has no face now
  mesh.faces.erase(mesh.faces.begin());
  const Document source = document_from_mesh(mesh);
  expect_same_after(source, exactly(3));
  Document document = source;
  EncodeDocumentOptions options = exactly(3);
  options.drop_degenerate = true;
  const auto reports = encode_document(document, options, cpu_backend(), pool());
  ASSERT_TRUE(reports);
  EXPECT_EQ(reports->front().statistics.dropped_faces, 1u);
  EXPECT_EQ(read(document).faces.size(), mesh.faces.size() - 1);
}

// What validation says about an encoded document after `damage`.
std::vector<std::string> findings_after(const std::function<void(Document&, Json& extension)>& damage) {
  Document document = document_from_mesh(loaded_grid(20));
  EXPECT_TRUE(encode_document(document, exactly(3), cpu_backend(), pool()));
  damage(document, document.json["meshes"][0]["primitives"][0]["extensions"][kExtensionName]);
  std::vector<std::string> rules;
  for (const Finding& finding : validate_document(document, cpu_backend(), pool()))
    rules.push_back(finding.rule);
  return rules;
}

TEST(Validate, NamesTheRuleThatIsBroken) {
  using Rules = std::vector<std::string>;
  EXPECT_EQ(findings_after([](Document&, Json&) {}), Rules{});
  EXPECT_EQ(findings_after([](Document& d, Json&) { d.json.erase("extensionsRequired"); }),
            Rules{"extension-required"});
  EXPECT_EQ(findings_after([](Document& d, Json&) { d.json["extensionsUsed"] = Json::array({"OTHER"}); }),
            Rules{"extension-used"});
  EXPECT_EQ(findings_after([](Document& d, Json&) { d.json["meshes"][0]["primitives"][0]["mode"] = 5; }),
            Rules{"mode"});
  EXPECT_EQ(findings_after([](Document&, Json& e) { e.erase("bufferView"); }), Rules{"members"});
  EXPECT_EQ(findings_after([](Document&, Json& e) { e["bufferView"] = 99; }), Rules{"members"});
  EXPECT_EQ(findings_after([](Document&, Json& e) { e["attributes"]["POSITION"] = 99; }), Rules{"decode"});
  EXPECT_EQ(findings_after([](Document& d, Json&) { d.json["accessors"][0]["count"] = 3; }).front(),
            "accessor-count");
  EXPECT_EQ(findings_after([](Document& d, Json& e) {
              const auto view = e["bufferView"].get<int64_t>();
              const auto offset =
                  d.json["bufferViews"][static_cast<size_t>(view)].value("byteOffset", size_t{0});
              d.buffers[0][offset] = 'x';
            }),
            Rules{"container"});
  EXPECT_EQ(findings_after([](Document& d, Json&) {
              d.json["meshes"][0]["primitives"][0].erase("extensions");
            }).front(),
            "extension-unused");
}

}  // namespace
}  // namespace psplit
