// Documents with condensed patches, and the way back.
#include "encoder/draco/draco_backend.h"
#include "gltf_ext/convert/document_from_mesh.h"
#include "gltf_ext/convert/encode_document_stock.h"
#include "gltf_ext/convert/expand_document.h"
#include "gltf_ext/convert/validate.h"
#include "src/container/patch_container.h"
#include "src/cpu/cpu_backend.h"
#include "tests/gltf_ext/asset.h"

namespace psplit {
namespace {

constexpr uint32_t kColumns = 90, kRows = 70;

EncodeDocumentOptions condensing(uint64_t patches = 0) {
  const EncodeDocumentOptions options{.patches = {.count = patches}, .condense = true};
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

// A primitive in one stream of stock Draco.
Document stock_document(const Mesh& mesh) {
  Document document = document_from_mesh(mesh);
  EXPECT_TRUE(encode_document_stock(document, {}, test_pool()).ok());
  return document;
}

TEST(Condense, PatchesExpandToThoseOfDraco) {
  Document plain = document_from_mesh(rich_mesh(kColumns, kRows)), condensed = plain;
  ASSERT_TRUE(encode_with(plain, {.patches = {.count = 5}}).ok());
  ASSERT_TRUE(encode_with(condensed, condensing(5)).ok());
  EXPECT_TRUE(is_condensed(condensed));
  EXPECT_EQ(without_views(condensed), without_views(plain));
  EXPECT_EQ(findings_of(condensed, cpu_backend()), "");

  const auto report = must(expand_document(condensed, test_pool()));
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
  const auto report = must(expand_document(condensed, test_pool()));
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
  ASSERT_TRUE(expand_document(document, test_pool()).ok());
  EXPECT_EQ(document.json()["extensionsUsed"], Json::array({kStockExtensionName}));
  EXPECT_FALSE(document.json().contains("extensionsRequired"));
  EXPECT_TRUE(accessor_of(document, "POSITION").contains("bufferView"));
}

// Someone's asset: the stream is not encoded again, and comes back in all its bytes.
TEST(Condense, StockDracoIsCondensedAsItIs) {
  for (const Mesh& mesh : {make_grid(kColumns, kRows), rich_mesh(kColumns, kRows)}) {
    const Document before = stock_document(mesh);
    Document document = before;
    const auto reports = must(encode_document(document, condensing(), cpu_backend(), test_pool()));
    EXPECT_EQ(reports.at(0).stored_as, StoredAs::kPatches);
    EXPECT_LT(reports.at(0).bytes, reports.at(0).input_bytes);
    EXPECT_TRUE(is_condensed(document));
    EXPECT_EQ(findings_of(document, cpu_backend()), "");
    ASSERT_TRUE(expand_document(document, test_pool()).ok());
    EXPECT_EQ(stored_bytes(document, kStockExtensionName), stored_bytes(before, kStockExtensionName));
    EXPECT_EQ(document.json()["accessors"], before.json()["accessors"]);
  }
}

// Patches that the input has already: nothing is encoded again.
TEST(Condense, PatchesAreCondensedAsTheyAre) {
  Document before = document_from_mesh(rich_mesh(kColumns, kRows));
  ASSERT_TRUE(encode_with(before, {.patches = {.count = 5}}).ok());
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
  ASSERT_TRUE(expand_document(document, test_pool()).ok());
  EXPECT_EQ(stored_bytes(document, kExtensionName), stored_bytes(before, kExtensionName));
}

// Splitting changes the order of points, so EXT_mesh_manifold is dropped. Condensing a stream does not.
TEST(Condense, StockDracoThatIsCondensedKeepsItsManifold) {
  Document document = stock_document(make_grid(kColumns, kRows));
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
  EncodeDocumentOptions options{.patches = {.count = 3}, .compat = Compat::kKhr};
  ASSERT_TRUE(encode_with(plain, options).ok());
  options.condense = true;
  ASSERT_TRUE(encode_with(condensed, options).ok());
  EXPECT_EQ(condensed.json(), plain.json());
}

TEST(Condense, ExpandLeavesEverythingElse) {
  Document document = document_from_mesh(make_grid(kColumns, kRows));
  ASSERT_TRUE(encode(document).ok());
  const Document before = document;
  const auto report = must(expand_document(document, test_pool()));
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
    EXPECT_EQ(expand_document(mutant, test_pool()).ok(), agrees) << bit;
  }
  EXPECT_GT(refused, 10u);
  EXPECT_GT(accepted, 10u);
}

// A stitch map joins points of a single patch; stock Draco repeats them.
TEST(Condense, ASinglePatchWithAFallbackStaysAContainer) {
  Document document = document_from_mesh(rich_mesh(kColumns, kRows));
  EncodeDocumentOptions options = condensing(1);
  options.fallback = Fallback::kUncompressed;
  ASSERT_TRUE(encode_with(document, options).ok());
  const bool has_references = open_container(stored_bytes(document, kExtensionName))->reference_count() > 0;
  const auto report = must(expand_document(document, test_pool()));
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
  const Status status = expand_document(document, test_pool()).status();
  EXPECT_EQ(status.code(), StatusCode::kInvalidInput);
  EXPECT_EQ(status.place().mesh, 0);
  EXPECT_EQ(status.place().primitive, 0);
}

}  // namespace
}  // namespace psplit
