// Documents with condensed patches, and the way back.
#include "gltf_ext/convert/validate.h"
#include "psplit/decode.h"
#include "psplit/document.h"
#include "psplit/encode.h"
#include "psplit/gltf.h"
#include "src/container/patch_container.h"
#include "tests/gltf_ext/asset.h"

namespace psplit {
namespace {

constexpr uint32_t kColumns = 90, kRows = 70;

EncodeDocumentOptions condensing(uint64_t patches = 0) {
  const EncodeDocumentOptions options = DocumentOptions{.patches = {.count = patches}, .condense = true};
  return options;
}

Status encode_with(Document& document, const EncodeDocumentOptions& options) {
  return encode_document(document, options, cpu_backend(), test_pool()).status();
}

std::vector<uint8_t> stored_bytes(const Document& document, const char* extension) {
  const PrimitiveRecord& primitive = document.records().primitive({0, 0});
  EXPECT_EQ(primitive.patches.has_value(), extension == std::string(kExtensionName));
  const StoredPrimitive stored = must(stored_primitive(document, {0, 0}));
  return {stored.bytes.begin(), stored.bytes.end()};
}

bool is_condensed(const Document& document) {
  const std::vector<uint8_t> bytes = stored_bytes(document, kExtensionName);
  return open_container(bytes)->condensed_count() > 0;
}

// The JSON without what describes the bytes.
Json without_views(const Document& document) {
  Json json = document.json();
  json.erase("buffers");
  json.erase("bufferViews");
  return json;
}

// A sheet whose heights no encoder predicts.
Mesh rough_sheet() {
  const Mesh flat = make_grid(kColumns, kRows);
  std::vector<float> positions = values_of<float>(flat.attributes[0]);
  for (size_t i = 2; i < positions.size(); i += 3) positions[i] = std::sin(static_cast<float>(i * i % 1009));
  return make_mesh(positions, flat.faces);
}

// A primitive in one stream of stock Draco, of few bits: it would grow if it were encoded again.
Document stock_document(const Mesh& mesh) {
  Document document = document_from_mesh(mesh);
  const EncodeDocumentOptions coarse = DocumentOptions{
      .position_bits = 9, .normal_bits = 6, .texcoord_bits = 8, .color_bits = 5, .generic_bits = 8};
  EXPECT_TRUE(encode_document_stock(document, coarse, test_pool()).ok());
  return document;
}

TEST(Condense, PatchesExpandToThoseOfDraco) {
  Document plain = document_from_mesh(rich_mesh(kColumns, kRows)), condensed = plain;
  ASSERT_TRUE(encode_with(plain, DocumentOptions{.patches = {.count = 5}}).ok());
  ASSERT_TRUE(encode_with(condensed, condensing(5)).ok());
  EXPECT_TRUE(is_condensed(condensed));
  EXPECT_EQ(without_views(condensed), without_views(plain));
  EXPECT_EQ(findings_of(condensed, cpu_backend()), "");

  const auto report = must(expand_document(condensed, cpu_backend(), test_pool()));
  EXPECT_EQ(report.to_patches, 1u);
  EXPECT_EQ(report.to_draco, 0u);
  EXPECT_LT(report.bytes_before, report.bytes_after);
  EXPECT_EQ(stored_bytes(condensed, kExtensionName), stored_bytes(plain, kExtensionName));
  EXPECT_EQ(without_views(condensed), without_views(plain));
  EXPECT_EQ(findings_of(condensed, cpu_backend()), "");
}

TEST(Condense, APrimitiveThatStaysWholeBecomesOnePatchAndExpandsToStockDraco) {
  Document plain = document_from_mesh(make_grid(kColumns, kRows)), condensed = plain;
  ASSERT_TRUE(encode_with(plain, {}).ok());
  ASSERT_TRUE(encode_with(condensed, condensing()).ok());
  EXPECT_TRUE(is_condensed(condensed));
  EXPECT_EQ(findings_of(condensed, cpu_backend()), "");
  const auto report = must(expand_document(condensed, cpu_backend(), test_pool()));
  EXPECT_EQ(report.to_draco, 1u);
  EXPECT_EQ(stored_bytes(condensed, kStockExtensionName), stored_bytes(plain, kStockExtensionName));
  EXPECT_EQ(without_views(condensed), without_views(plain));
}

TEST(Condense, AFallbackStaysAndTheExtensionIsNotRequired) {
  Document document = document_from_mesh(make_grid(kColumns, kRows));
  EncodeDocumentOptions options = condensing();
  options.fallback = Fallback::kUncompressed;
  ASSERT_TRUE(encode_with(document, options).ok());
  EXPECT_TRUE(is_condensed(document));
  ASSERT_TRUE(expand_document(document, cpu_backend(), test_pool()).ok());
  EXPECT_EQ(document.json()["extensionsUsed"], Json::array({kStockExtensionName}));
  EXPECT_FALSE(document.json().contains("extensionsRequired"));
  EXPECT_TRUE(accessor_of(document, "POSITION").contains("bufferView"));
}

// Someone's asset: the stream is not encoded again, and comes back in all its bytes.
TEST(Condense, StockDracoIsCondensedAsItIs) {
  for (const Mesh& mesh : {rough_sheet(), rich_mesh(kColumns, kRows)}) {
    Document before = stock_document(mesh);
    // Decoded points have another order, in which the stream may be smaller.
    for (size_t bytes = SIZE_MAX; stored_bytes(before, kStockExtensionName).size() < bytes;) {
      bytes = stored_bytes(before, kStockExtensionName).size();
      ASSERT_TRUE(encode_with(before, {}).ok());
    }
    Document document = before;
    const auto reports = must(encode_document(document, condensing(), cpu_backend(), test_pool()));
    EXPECT_EQ(reports.at(0).stored_as, StoredAs::kPatches);
    EXPECT_LT(reports.at(0).bytes, reports.at(0).input_bytes);
    EXPECT_TRUE(is_condensed(document));
    EXPECT_EQ(findings_of(document, cpu_backend()), "");
    ASSERT_TRUE(expand_document(document, cpu_backend(), test_pool()).ok());
    EXPECT_EQ(stored_bytes(document, kStockExtensionName), stored_bytes(before, kStockExtensionName));
    EXPECT_EQ(document.json()["accessors"], before.json()["accessors"]);
  }
}

// A primitive that is encoded again without condensing is encoded again.
TEST(Condense, StockDracoThatIsEncodedAgainIsCondensedThen) {
  const Document before = stock_document(rough_sheet());
  EncodeDocumentOptions coarse = DocumentOptions{.position_bits = 6};
  Document plain = before, condensed = before;
  ASSERT_TRUE(encode_with(plain, coarse).ok());
  ASSERT_NE(stored_bytes(plain, kStockExtensionName), stored_bytes(before, kStockExtensionName));
  coarse.condense = Condense::kFast;
  const auto reports = must(encode_document(condensed, coarse, cpu_backend(), test_pool()));
  EXPECT_FALSE(reports.at(0).keeps_streams);
  EXPECT_TRUE(is_condensed(condensed));
  ASSERT_TRUE(expand_document(condensed, cpu_backend(), test_pool()).ok());
  EXPECT_EQ(stored_bytes(condensed, kStockExtensionName), stored_bytes(plain, kStockExtensionName));
  EXPECT_EQ(condensed.json(), plain.json());
}

// Other encoders write the bounds of their input. A container needs the bounds of the decoded values.
TEST(Condense, BoundsOfStockDracoBecomeExact) {
  const Document exact = stock_document(rough_sheet());
  Document document = exact;
  accessor_of(document, "POSITION")["max"][0] = 12345.678;
  accessor_of(document, "indices")["max"] = {7};
  Document shared = document;
  ASSERT_TRUE(encode_with(document, condensing()).ok());
  EXPECT_TRUE(is_condensed(document));
  EXPECT_EQ(findings_of(document, cpu_backend()), "");
  ASSERT_TRUE(expand_document(document, cpu_backend(), test_pool()).ok());
  EXPECT_EQ(stored_bytes(document, kStockExtensionName), stored_bytes(exact, kStockExtensionName));
  // An accessor that something else uses is not changed.
  shared.json()["animations"] = Json::array(
      {{{"samplers",
         Json::array({{{"input", 0}, {"output", primitive_of(shared)["attributes"]["POSITION"]}}})}}});
  const Json before = shared.json();
  ASSERT_TRUE(encode_with(shared, condensing()).ok());
  EXPECT_EQ(shared.json(), before);
}

// The bytes would stay for the other view.
TEST(Condense, ViewsOfTheSameBytesStay) {
  const auto with_second_view = [](Document document) {
    Json& views = document.json()["bufferViews"];
    views.push_back(Json(views[0]));
    Json& primitives = document.json()["meshes"][0]["primitives"];
    primitives.push_back(Json(primitives[0]));
    for (auto& extension : primitives[1]["extensions"]) extension["bufferView"] = views.size() - 1;
    return document;
  };
  Document patches = document_from_mesh(make_grid(kColumns, kRows));
  ASSERT_TRUE(encode_with(patches, DocumentOptions{.patches = {.count = 5}}).ok());
  for (const Document& before : {with_second_view(stock_document(rough_sheet())), with_second_view(patches)}) {
    Document document = before;
    const auto reports = must(encode_document(document, condensing(), cpu_backend(), test_pool()));
    for (const PrimitiveReport& report : reports) EXPECT_EQ(report.stored_as, StoredAs::kAsItWas);
    EXPECT_EQ(document.json(), before.json());
  }
}

// A book: all pages meet in the edges of its spine.
Mesh book(uint32_t pages, uint32_t rows) {
  std::vector<float> positions;
  for (uint32_t edge = 0; edge <= pages; ++edge)  // the spine, then the outer edge of each page
    for (uint32_t row = 0; row <= rows; ++row) {
      const auto angle = static_cast<float>(edge), height = static_cast<float>(row);
      const float radius = edge == 0 ? 0.0f : 1.0f;
      positions.insert(positions.end(), {radius * std::cos(angle), radius * std::sin(angle),
                                         height + 0.4f * std::sin(height * height + angle)});
    }
  Faces faces;
  for (uint32_t page = 0; page < pages; ++page)
    for (uint32_t row = 0; row < rows; ++row) {
      const uint32_t point = (page + 1) * (rows + 1) + row;
      faces.push_back({row, point, point + 1});
      faces.push_back({row, point + 1, row + 1});
    }
  return make_mesh(positions, faces);
}

// Stock Draco repeats the points of the spine on each page. A stitch map joins them, also in other data.
TEST(Condense, PointsThatStockDracoRepeatsAreJoined) {
  const Mesh mesh = book(9, 200);
  const Document input = document_from_mesh(mesh);
  Document plain = input, condensed = input;
  ASSERT_TRUE(encode_with(plain, {}).ok());
  const uint32_t repeated = must(read(plain)).point_count;
  const auto reports = must(encode_document(condensed, condensing(), cpu_backend(), test_pool()));
  ASSERT_TRUE(is_condensed(condensed));
  EXPECT_EQ(must(read(condensed)).point_count, mesh.point_count);
  EXPECT_LT(mesh.point_count, repeated);
  EXPECT_GT(open_container(stored_bytes(condensed, kExtensionName))->reference_count(), 0u);
  EXPECT_EQ(findings_of(condensed, cpu_backend()), "");
  ASSERT_TRUE(expand_document(condensed, cpu_backend(), test_pool()).ok());
  EXPECT_EQ(condensed.json(), plain.json());

  Document morphed = input;
  const std::vector<float> deltas = values_of<float>(mesh.attributes[0]);
  primitive_of(morphed)["targets"] = Json::array(
      {{{"POSITION", append_accessor(morphed, make_data(ComponentType::kFloat32, 3, deltas), 34962, true)}}});
  EncodeDocumentOptions options = condensing();
  options.fallback = Fallback::kUncompressed;
  options.lossless = true;
  ASSERT_TRUE(encode_with(morphed, options).ok());
  ASSERT_TRUE(is_condensed(morphed));
  EXPECT_EQ(must(read(morphed)).point_count, mesh.point_count);
  EXPECT_EQ(findings_of(morphed, cpu_backend()), "");
  const auto targets = must(read_morph_targets(morphed, {0, 0}));
  EXPECT_EQ(targets.at(0).data.values, read(morphed)->find("POSITION")->values);
}

// Patches that the input has already: nothing is encoded again.
TEST(Condense, PatchesAreCondensedAsTheyAre) {
  Document before = document_from_mesh(rich_mesh(kColumns, kRows));
  ASSERT_TRUE(encode_with(before, DocumentOptions{.patches = {.count = 5}}).ok());
  // Another primitive has the same container.
  Json& primitives = before.json()["meshes"][0]["primitives"];
  primitives.push_back(Json(primitives[0]));
  Document document = before, at_once = document_from_mesh(rich_mesh(kColumns, kRows));
  ASSERT_TRUE(encode_with(at_once, condensing(5)).ok());
  // Options of encoding do not count.
  EncodeDocumentOptions others = condensing(2);
  others.position_bits = 8;
  const auto reports = must(encode_document(document, others, cpu_backend(), test_pool()));
  for (const PrimitiveReport& report : reports) {
    EXPECT_EQ(report.skipped, "");
    EXPECT_EQ(report.stored_as, StoredAs::kPatches);
    EXPECT_TRUE(report.keeps_streams);
    EXPECT_EQ(report.streams.size(), 5u);
    EXPECT_EQ(report.faces, rich_mesh(kColumns, kRows).faces.size());
  }
  EXPECT_FALSE(reports.at(0).repeated);
  EXPECT_TRUE(reports.at(1).repeated);
  EXPECT_EQ(reports.at(0).bytes, stored_bytes(document, kExtensionName).size());
  EXPECT_LT(reports.at(0).bytes, reports.at(0).input_bytes);
  EXPECT_EQ(stored_bytes(document, kExtensionName), stored_bytes(at_once, kExtensionName));
  EXPECT_EQ(without_views(document), without_views(before));
  EXPECT_EQ(findings_of(document, cpu_backend()), "");

  const auto again = must(encode_document(document, condensing(), cpu_backend(), test_pool()));
  EXPECT_EQ(again.at(0).skipped, "already in condensed patches");
  ASSERT_TRUE(expand_document(document, cpu_backend(), test_pool()).ok());
  EXPECT_EQ(stored_bytes(document, kExtensionName), stored_bytes(before, kExtensionName));
}

// Splitting changes the order of points, so EXT_mesh_manifold is dropped. Condensing a stream does not.
TEST(Condense, StockDracoThatIsCondensedKeepsItsManifold) {
  Document document = stock_document(rough_sheet());
  document.json()["meshes"][0]["extensions"]["EXT_mesh_manifold"] = {
      {"manifoldPrimitive", {{"indices", primitive_of(document)["indices"]}}}};
  Document split = document;
  ASSERT_TRUE(encode_with(document, condensing()).ok());
  EXPECT_TRUE(is_condensed(document));
  EXPECT_EQ(count_in(document, "EXT_mesh_manifold"), 1u);
  ASSERT_TRUE(encode_with(split, condensing(3)).ok());
  EXPECT_EQ(count_in(split, "EXT_mesh_manifold"), 0u);
}

TEST(Condense, CompatKhrIsTheSameWithAndWithout) {
  Document plain = document_from_mesh(make_grid(kColumns, kRows)), condensed = plain;
  EncodeDocumentOptions options = DocumentOptions{.patches = {.count = 3}, .compat = Compat::kKhr};
  ASSERT_TRUE(encode_with(plain, options).ok());
  options.condense = Condense::kFast;
  ASSERT_TRUE(encode_with(condensed, options).ok());
  EXPECT_EQ(condensed.json(), plain.json());
}

TEST(Condense, ExpandLeavesEverythingElse) {
  Document document = document_from_mesh(make_grid(kColumns, kRows));
  ASSERT_TRUE(encode(document).ok());
  const Document before = document;
  const auto report = must(expand_document(document, cpu_backend(), test_pool()));
  EXPECT_EQ(report.to_patches + report.to_draco, 0u);
  EXPECT_EQ(document.json(), before.json());
}

// A flipped bit anywhere in the container: all readers refuse it, or none.
TEST(Condense, AMutantHasOneVerdict) {
  Document document = document_from_mesh(rich_mesh(12, 10));
  ASSERT_TRUE(encode_with(document, condensing(3)).ok());
  const size_t size = stored_bytes(document, kExtensionName).size();
  const auto offset = static_cast<size_t>(stored_primitive(document, {0, 0})->bytes.data() -
                                          std::span<const uint8_t>(document.buffers[0]).data());
  size_t refused = 0, accepted = 0;
  for (size_t bit = 0; bit < 8 * size; bit += bit < 8000 ? 29 : 113) {
    Document mutant = document;
    uint8_t& byte = mutant.buffers[0].own()[offset + bit / 8];
    byte = static_cast<uint8_t>(byte ^ 1u << bit % 8);
    const bool decodes = read_primitive(mutant, {0, 0}, cpu_backend(), test_pool()).ok();
    ++(decodes ? accepted : refused);
    EXPECT_EQ(read_primitive(mutant, {0, 0}, draco_backend(), test_pool()).ok(), decodes) << bit;
    bool is_container_valid = true;
    for (const Finding& finding : validate_document(mutant, cpu_backend(), test_pool()))
      if (finding.rule == "container" || finding.rule == "decode") is_container_valid = false;
    EXPECT_EQ(is_container_valid, decodes) << bit;
    // Values that the accessors contradict are refused as well.
    Document decoded = mutant;
    const bool agrees = decode_document(decoded, cpu_backend(), test_pool()).ok();
    EXPECT_TRUE(decodes || !agrees) << bit;
    EXPECT_EQ(expand_document(mutant, cpu_backend(), test_pool()).ok(), agrees) << bit;
  }
  EXPECT_GT(refused, 10u);
  EXPECT_GT(accepted, 10u);
}

// A stitch map joins points of a single patch, and the fallback has them joined. Stock Draco repeats them.
TEST(Condense, ASinglePatchWithAFallbackStaysAContainer) {
  Document document = document_from_mesh(rich_mesh(kColumns, kRows));
  EncodeDocumentOptions options = condensing(1);
  options.patches.always = true;
  options.fallback = Fallback::kUncompressed;
  ASSERT_TRUE(encode_with(document, options).ok());
  const bool has_references = open_container(stored_bytes(document, kExtensionName))->reference_count() > 0;
  const auto report = must(expand_document(document, cpu_backend(), test_pool()));
  EXPECT_EQ(report.to_patches, has_references ? 1u : 0u);
  EXPECT_EQ(findings_of(document, cpu_backend()), "");
}

TEST(Condense, ExpandNamesTheBrokenPrimitive) {
  Document document = document_from_mesh(make_grid(kColumns, kRows));
  ASSERT_TRUE(encode_with(document, condensing(3)).ok());
  Json& view =
      document.json()["bufferViews"]
                     [primitive_of(document)["extensions"][kExtensionName]["bufferView"].get<size_t>()];
  view["byteLength"] = view["byteLength"].get<size_t>() - 1;
  const Status status = expand_document(document, cpu_backend(), test_pool()).status();
  EXPECT_EQ(status.code(), StatusCode::kInvalidInput);
  EXPECT_EQ(status.place().mesh, 0);
  EXPECT_EQ(status.place().primitive, 0);
}

}  // namespace
}  // namespace psplit
