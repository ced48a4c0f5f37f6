// How each primitive is stored by default: split, as one Draco stream, or as it was.
#include <algorithm>
#include <array>
#include <map>
#include <mutex>

#include "encoder/coding/quantization.h"
#include "gltf_ext/convert/encode_job.h"
#include "gltf_ext/convert/validate.h"
#include "mesh_files/draco_file.h"
#include "psplit/decode.h"
#include "psplit/document.h"
#include "psplit/encode.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/stock_stream.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

Expected<std::vector<PrimitiveReport>> encode_by_default(Document& document,
                                                         const EncodeDocumentOptions& options = {}) {
  return encode_document(document, options, cpu_backend(), test_pool());
}

// One mesh of two primitives; the second has more faces.
Document small_and_large() {
  Document document = document_from_mesh(make_grid(10, 10)), other = document_from_mesh(make_grid(60, 40));
  const Expected<Mesh> large = read(other);
  Json primitive = primitive_of(document);
  primitive["attributes"]["POSITION"] = append_accessor(
      document, make_data(ComponentType::kFloat32, 3, values_of<float>(large->attributes[0])), 34962, true);
  std::vector<uint32_t> indices;
  for (const auto& face : large->faces) indices.insert(indices.end(), face.begin(), face.end());
  primitive["indices"] = append_accessor(document, make_data(ComponentType::kUint32, 1, indices), 34963, false);
  document.json()["meshes"][0]["primitives"].push_back(primitive);
  return document;
}

TEST(StorageChoice, DefaultPatchCountsKeepThreadsBusy) {
  const std::map<uint64_t, uint64_t> counts = {{1, 1},       {19999, 1},   {20000, 2},   {84000, 2},
                                               {86000, 4},   {169000, 4},  {170000, 8},  {339000, 8},
                                               {340000, 16}, {719000, 16}, {871414, 32}, {10000000, 336}};
  for (const auto& [faces, patches] : counts) EXPECT_EQ(default_patch_count(faces), patches) << faces;
  EXPECT_EQ(default_patch_count(5000, 5000), 2u);
  EXPECT_EQ(default_patch_count(100000, 200000), 1u);
}

// Progress comes patch by patch for one large primitive. It also counts faces that are in no patch.
TEST(StorageChoice, ProgressCountsTheFacesOfPatches) {
  Mesh mesh = make_grid(40, 40);
  mesh.faces.push_back({0, 0, 1});
  Document document = document_from_mesh(mesh);
  const EncodeDocumentOptions options = DocumentOptions{.patches = {.count = 5}};
  std::mutex mutex;
  std::vector<size_t> done;
  must(encode_document(document, options, cpu_backend(), test_pool(), [&](size_t faces, size_t total) {
    const std::lock_guard lock(mutex);
    EXPECT_EQ(total, mesh.faces.size());
    done.push_back(faces);
  }));
  std::ranges::sort(done);
  ASSERT_EQ(done.size(), 7u);
  EXPECT_EQ(done[0], 0u);
  EXPECT_LT(done[1], mesh.faces.size() / 4);
  EXPECT_EQ(done.back(), mesh.faces.size());
}

// A .drc file states no bounds, but glTF requires bounds of positions.
TEST(StorageChoice, ADracoFileThatStaysAsItIsGetsItsBounds) {
  const Mesh mesh = make_grid(30, 20);
  AttributeCoding grid = must(fit_grid(mesh.attributes[0], 14));
  std::vector<AttributeCoding> codings(mesh.attributes.size());
  codings[0] = grid;
  const StockStream stream = must(encode_stock_stream(mesh, codings, 0));
  Document document = must(document_from_draco(stream.bytes, describe_stream));
  const auto reports = must(encode_by_default(document));
  ASSERT_NE(reports[0].skipped, "");
  const Json accessor = accessor_of(document, "POSITION");
  ASSERT_TRUE(accessor.contains("min") && accessor.contains("max")) << accessor;
  EXPECT_EQ(findings_of(document, draco_backend()), "");
  ASSERT_TRUE(decode(document).ok());
  EXPECT_EQ(accessor_of(document, "POSITION")["min"], accessor["min"]);
  EXPECT_EQ(accessor_of(document, "POSITION")["max"], accessor["max"]);
}

// Accessors of attributes cannot have integers of 32 bits: they become floats, which keep them.
TEST(StorageChoice, ADracoFileOfWideIntegersIsEncodedAnew) {
  for (const char* semantic : {"POSITION", "_ID"}) {
    SCOPED_TRACE(semantic);
    Mesh mesh = make_grid(30, 20);
    mesh.attributes.resize(1);
    std::vector<uint32_t> numbers;
    for (uint32_t i = 0; i < 3 * mesh.point_count; ++i)
      numbers.push_back(5'000'000 + i % 3 * 1'000'000 + i * i % 50'021);
    Attribute attribute{semantic, ComponentType::kUint32, 3, false, {}};
    attribute.values.resize(numbers.size() * sizeof(uint32_t));
    std::memcpy(attribute.values.data(), numbers.data(), attribute.values.size());
    if (attribute.semantic == "POSITION")
      mesh.attributes[0] = attribute;
    else
      mesh.attributes.push_back(attribute);
    const std::vector<AttributeCoding> codings(mesh.attributes.size());
    const StockStream stream = must(encode_stock_stream(mesh, codings, 0));
    Document document = must(document_from_draco(stream.bytes, describe_stream));
    EXPECT_EQ(findings_of(document, draco_backend()), "");
    const auto reports = must(encode_by_default(document, DocumentOptions{.keep_duplicates = true}));
    EXPECT_EQ(reports[0].skipped, "");
    EXPECT_EQ(findings_of(document, draco_backend()), "");
    ASSERT_TRUE(decode(document).ok());
    const Expected<Mesh> decoded = read(document);
    const Attribute* const floats = decoded->find(attribute.semantic == "POSITION" ? "POSITION" : "_GENERIC_0");
    ASSERT_NE(floats, nullptr);
    std::vector<float> found = values_of<float>(*floats), expected(numbers.begin(), numbers.end());
    std::ranges::sort(found);
    std::ranges::sort(expected);
    EXPECT_EQ(found, expected);
  }
}

TEST(StorageChoice, WholePrimitivesAreStockDracoOfNoMoreBytes) {
  const Mesh mesh = rich_mesh(30, 20);
  Document document = document_from_mesh(mesh), stock = document;
  const auto reports = must(encode_by_default(document));
  EXPECT_EQ(reports[0].stored_as, StoredAs::kDraco);
  EXPECT_EQ(reports[0].streams.size(), 1u);
  EXPECT_GT(reports[0].input_bytes, reports[0].bytes);
  EXPECT_EQ(document.json()["extensionsUsed"], Json::array({kStockExtensionName}));
  EXPECT_EQ(document.json()["extensionsRequired"], Json::array({kStockExtensionName}));
  EXPECT_EQ(count_in(document, kExtensionName), 0u);
  EXPECT_EQ(document.json()["bufferViews"].size(), 1u);
  const auto by_draco = must(encode_document_stock(stock, {}, test_pool()));
  EXPECT_EQ(reports[0].bytes, by_draco[0].bytes);
  EXPECT_EQ(compare_meshes(*read(stock), *read(document)), "");
  ASSERT_TRUE(decode(document).ok());
  EXPECT_EQ(compare_meshes(*read(stock), *read(document)), "");
}

TEST(StorageChoice, OneAssetMayHoldBothExtensions) {
  for (const Fallback fallback : {Fallback::kNone, Fallback::kUncompressed}) {
    Document document = small_and_large();
    const Expected<Mesh> small = read(document), large = read(document, 0, 1);
    const EncodeDocumentOptions options =
        DocumentOptions{.patches = {.faces = 1000}, .lossless = true, .fallback = fallback};
    const auto reports = must(encode_by_default(document, options));
    EXPECT_EQ(reports[0].stored_as, StoredAs::kDraco);
    EXPECT_EQ(reports[1].stored_as, StoredAs::kPatches);
    EXPECT_EQ(reports[1].statistics.patch_count, 5u);
    const Json both = Json::array({kStockExtensionName, kExtensionName});
    EXPECT_EQ(document.json()["extensionsUsed"], both);
    EXPECT_EQ(document.json().contains("extensionsRequired"), fallback == Fallback::kNone);
    if (fallback == Fallback::kNone) {
      EXPECT_EQ(document.json()["extensionsRequired"], both);
    }
    EXPECT_EQ(findings_of(document, draco_backend()), "");
    EXPECT_EQ(compare_meshes(*small, *read(document)), "");
    EXPECT_EQ(compare_meshes(*large, *read(document, 0, 1)), "");
    Document loader = document;  // a loader that knows neither extension
    if (fallback == Fallback::kNone)
      ASSERT_TRUE(decode(loader).ok());
    else
      for (size_t p = 0; p < 2; ++p) primitive_of(loader, 0, p).erase("extensions");
    EXPECT_EQ(compare_meshes(*small, *read(loader)), "");
    EXPECT_EQ(compare_meshes(*large, *read(loader, 0, 1)), "");
  }
}

TEST(StorageChoice, MinFacesAndAlwaysPatches) {
  const auto stored = [](EncodeDocumentOptions options) {
    Document document = small_and_large();
    const auto reports = must(encode_by_default(document, options));
    return std::array{reports[0].stored_as, reports[1].stored_as};
  };
  using enum StoredAs;
  EXPECT_EQ(stored({}), (std::array{kDraco, kDraco}));
  EXPECT_EQ(stored(DocumentOptions{.patches = {.min_faces = 4000}}), (std::array{kDraco, kPatches}));
  EXPECT_EQ(stored(DocumentOptions{.patches = {.always = true}}), (std::array{kPatches, kPatches}));
  EXPECT_EQ(stored(DocumentOptions{.patches = {.faces = 1000, .min_faces = 5000}}),
            (std::array{kDraco, kDraco}));
  EXPECT_EQ(stored(DocumentOptions{.patches = {.min_faces = 4000}, .compat = Compat::kKhr}),
            (std::array{kDraco, kPatchPrimitives}));
}

// Boxes that touch at their corners and edges: a container needs a reference for each point there.
Mesh touching_boxes(uint32_t side) {
  Mesh mesh;
  const uint32_t row = side + 1;
  std::vector<float> positions;
  for (uint32_t x = 0; x < row; ++x)
    for (uint32_t y = 0; y < row; ++y)
      for (float z : {0.f, 1.f})
        positions.insert(positions.end(), {static_cast<float>(x), static_cast<float>(y), z});
  mesh.point_count = 2 * row * row;
  mesh.attributes.push_back({"POSITION", ComponentType::kFloat32, 3, false, {}});
  mesh.attributes[0].values.resize(positions.size() * sizeof(float));
  std::memcpy(mesh.attributes[0].values.data(), positions.data(), mesh.attributes[0].values.size());
  constexpr uint32_t kQuads[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                     {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
  for (uint32_t x = 0; x < side; ++x)
    for (uint32_t y = 0; y < side; ++y)
      for (const auto& quad : kQuads) {
        uint32_t at[4];
        for (int i = 0; i < 4; ++i)
          at[i] = 2 * ((x + (quad[i] >> 2)) * row + y + (quad[i] >> 1 & 1)) + (quad[i] & 1);
        mesh.faces.push_back({at[0], at[1], at[2]});
        mesh.faces.push_back({at[0], at[2], at[3]});
      }
  return mesh;
}

// Of a mesh that is fine, patches cost a few percent. Of boxes that touch they would double the bytes, and of a
// regular grid one stream alone has its rows.
TEST(StorageChoice, SplittingCostsLittleUnlessItIsAskedFor) {
  for (const Mesh& mesh : {touching_boxes(45), make_grid(120, 110)}) {
    ASSERT_GT(mesh.faces.size(), kMinFaces);
    for (const bool condense : {false, true}) {
      const auto bytes_of = [&](PatchTarget patches, uint64_t& count) {
        Document document = document_from_mesh(mesh);
        const auto reports =
            must(encode_by_default(document, DocumentOptions{.patches = patches, .condense = condense}));
        EXPECT_EQ(findings_of(document, draco_backend()), "");
        count = reports[0].statistics.patch_count;
        return reports[0].bytes;
      };
      uint64_t one = 0, patches = 0, by_default = 0;
      const uint64_t least = bytes_of({.min_faces = 1000000}, one), split = bytes_of({.count = 2}, patches),
                     chosen = bytes_of({}, by_default);
      EXPECT_EQ(one, 1u);
      EXPECT_EQ(patches, 2u);
      EXPECT_LE(chosen * 100, least * 103) << condense << " split " << split;
    }
  }
}

// The limit looks at the stream's bytes, so libdraco's encoder gives the same patches.
TEST(StorageChoice, TheLimitOfPatchesDoesNotDependOnTheEncoder) {
  for (const Mesh& mesh : {touching_boxes(45), rich_mesh(120, 110)}) {
    uint64_t counts[2];
    for (const bool by_libdraco : {false, true}) {
      Document document = document_from_mesh(mesh);
      counts[by_libdraco] =
          must(encode_by_default(document, DocumentOptions{.by_libdraco = by_libdraco}))[0].bytes;
    }
    EXPECT_EQ(counts[0], counts[1]);
  }
}

// Draco takes the place of several buffer views. Their JSON is more than what a stream of one triangle takes
// beyond its data.
TEST(StorageChoice, JsonCounts) {
  const auto stored_as = [](bool is_long) {
    Document document = document_from_mesh(is_long ? rich_mesh(1, 1) : make_grid(1, 1));
    Json& json = document.json();
    if (is_long) {
      json["extensionsUsed"] = json["extensionsRequired"] = Json::array({kStockExtensionName});
      for (Json& view : json["bufferViews"])
        view["name"] = "a view that has a name of some length, " + std::string(200, '-');
    }
    const uint64_t before = glb_bytes(document);
    const auto reports = must(encode_by_default(document));
    EXPECT_LE(glb_bytes(document), before);
    return reports[0].stored_as;
  };
  EXPECT_EQ(stored_as(true), StoredAs::kDraco);
  EXPECT_EQ(stored_as(false), StoredAs::kAsItWas);
}

// A stock stream has points that Edgebreaker splits twice. Morph targets follow both copies.
TEST(StorageChoice, MorphTargetsFollowTheOneStream) {
  Mesh mesh = make_grid(16, 12);
  mesh.faces.erase(mesh.faces.begin() + 40, mesh.faces.begin() + 44);  // two fans at one point
  Document document = document_from_mesh(mesh);
  primitive_of(document)["targets"] = Json::array(
      {{{"POSITION",
         append_accessor(document, make_data(ComponentType::kFloat32, 3, values_of<float>(mesh.attributes[0])),
                         34962, true)}}});
  const auto reports = must(encode_by_default(document, DocumentOptions{.lossless = true}));
  ASSERT_EQ(reports[0].stored_as, StoredAs::kDraco);
  const auto morphs = read_morph_targets(document, {0, 0});
  ASSERT_TRUE(morphs && morphs->size() == 1);
  EXPECT_EQ((*morphs)[0].data.values, read(document)->find("POSITION")->values);
}

TEST(StorageChoice, StockDracoThatWouldGrowStays) {
  Document document = document_from_mesh(make_grid(60, 40));
  EncodeDocumentOptions coarse = DocumentOptions{.position_bits = 8};
  ASSERT_TRUE(encode_by_default(document, coarse));
  const Document stock = document;
  auto reports = must(encode_by_default(document));
  EXPECT_EQ(reports[0].stored_as, StoredAs::kAsItWas);
  EXPECT_TRUE(reports[0].skipped.starts_with("stock Draco that would take ")) << reports[0].skipped;
  EXPECT_EQ(reports[0].bytes, reports[0].input_bytes);
  EXPECT_EQ(document.json(), stock.json());
  // If the user asks for patches, they are written, with a warning.
  reports = must(encode_by_default(document, DocumentOptions{.patches = {.count = 4}}));
  EXPECT_EQ(reports[0].stored_as, StoredAs::kPatches);
  ASSERT_EQ(reports[0].warnings.size(), 1u);
  EXPECT_TRUE(reports[0].warnings[0].starts_with("grows: "));
  EXPECT_GT(reports[0].bytes, reports[0].input_bytes);
  // With a coarser quantization the result is smaller.
  document = stock;
  coarse.position_bits = 6;
  reports = must(encode_by_default(document, coarse));
  EXPECT_EQ(reports[0].stored_as, StoredAs::kDraco);
  EXPECT_LT(reports[0].bytes, reports[0].input_bytes);
}

// The bytes of the files that have the document.
uint64_t file_bytes(const Document& document, const char* name) {
  const TestFolder folder;
  WriteReport report;
  EXPECT_TRUE(write_document(document, folder / name, {}, &report).ok());
  uint64_t bytes = 0;
  for (const std::filesystem::path& file : report.files) bytes += std::filesystem::file_size(file);
  return bytes;
}

// Small meshes whose condensed streams take about as many bytes as their Draco streams: what the JSON of the
// extensions takes decides.
Mesh small_mesh(uint32_t columns, uint32_t rows) {
  const Mesh flat = make_grid(columns, rows);
  std::vector<float> positions = values_of<float>(flat.attributes[0]);
  for (size_t i = 2; i < positions.size(); i += 3)
    positions[i] = std::sin(static_cast<float>(i)) + 0.1f * static_cast<float>(i * i % 101);
  return make_mesh(positions, flat.faces);
}

TEST(StorageChoice, CondensingNeverMakesAFileLarger) {
  size_t condensed_count = 0, stock_count = 0, mixed_count = 0;
  for (uint32_t columns = 2; columns < 20; ++columns)
    for (const uint32_t tiny_count : {0u, 1u, 2u}) {
      Document document = document_from_mesh(small_mesh(columns, 3));
      for (uint32_t i = 0; i < tiny_count; ++i) add_mesh(document, small_mesh(2, 2));
      Document condensed = document;
      EncodeDocumentOptions options;
      if (columns % 3 == 0) options.fallback = Fallback::kUncompressed;
      must(encode_by_default(document, options));
      options.condense = Condense::kFast;
      must(encode_by_default(condensed, options));
      const bool is_condensed = count_in(condensed, kExtensionName) > 0;
      for (const char* name : {"a.glb", "a.gltf"}) {
        const uint64_t bytes = file_bytes(document, name), bytes_condensed = file_bytes(condensed, name);
        EXPECT_LE(bytes_condensed, bytes) << name << " of " << columns << " and " << tiny_count;
      }
      EXPECT_EQ(condensed.json() == document.json(), !is_condensed);
      ++(is_condensed ? condensed_count : stock_count);
      mixed_count += is_condensed && count_in(condensed, kStockExtensionName) > 0 ? 1 : 0;
    }
  EXPECT_GT(condensed_count, 10u);
  EXPECT_GT(stock_count, 10u);
  EXPECT_GT(mixed_count, 10u);
}

TEST(StorageChoice, AGeometrySmallerThanItsStreamStays) {
  const Document triangle = document_from_mesh(make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 1, 2}}));
  Document document = triangle;
  const auto reports = must(encode_by_default(document));
  EXPECT_EQ(reports[0].stored_as, StoredAs::kAsItWas);
  EXPECT_TRUE(reports[0].skipped.starts_with("Draco would take ")) << reports[0].skipped;
  EXPECT_EQ(reports[0].input_bytes, 42u);
  EXPECT_EQ(document.json(), triangle.json());
  // If other objects use a part of its data, these bytes stay.
  Document shared = triangle;
  Json points = primitive_of(shared);
  points["mode"] = 0;
  points.erase("indices");
  shared.json()["meshes"][0]["primitives"].push_back(points);
  const Json before = shared.json();
  const auto of_shared = must(encode_by_default(shared));
  EXPECT_TRUE(of_shared[0].skipped.ends_with(" more of JSON; what other objects use would stay"))
      << of_shared[0].skipped;
  EXPECT_EQ(shared.json(), before);
}

// Two primitives have the same points. What they share goes only if both are encoded.
TEST(StorageChoice, PrimitivesThatShareDataDoNotGrow) {
  const auto shared_by_two = [](uint32_t columns) {
    Document document = document_from_mesh(make_grid(columns, columns));
    Json second = primitive_of(document);
    second["indices"] = append_accessor(
        document, make_data(ComponentType::kUint16, 1, std::vector<uint16_t>{0, 1, 2}), 34963, false);
    document.json()["meshes"][0]["primitives"].push_back(second);
    return document;
  };
  for (const uint32_t columns : {2u, 40u}) {
    Document document = shared_by_two(columns);
    const Document before = document;
    const auto reports = must(encode_by_default(document));
    const size_t size = document.buffers[0].size(), size_before = before.buffers[0].size();
    EXPECT_EQ(reports[0].stored_as, columns == 2 ? StoredAs::kAsItWas : StoredAs::kDraco);
    EXPECT_EQ(reports[1].stored_as, reports[0].stored_as);
    EXPECT_LE(size, size_before);
    if (columns != 2) continue;
    EXPECT_EQ(document.json(), before.json());
    EXPECT_TRUE(reports[0].skipped.ends_with("together with the primitives that share its data"))
        << reports[0].skipped;
  }
  // The points of a primitive that is not encoded stay, and so do its morph targets.
  Document document = document_from_mesh(make_grid(3, 3));
  primitive_of(document)["targets"] = Json::array(
      {{{"POSITION",
         append_accessor(document, make_data(ComponentType::kFloat32, 3, std::vector<float>(48, 1.5f)), 34962,
                         true)}}});
  Json points = primitive_of(document);
  points["mode"] = 0;
  points.erase("indices");
  document.json()["meshes"][0]["primitives"].push_back(points);
  const Json before = document.json();
  ASSERT_TRUE(encode_by_default(document));
  EXPECT_EQ(document.json(), before);
}

// Patches of stock Draco take more than its stream. So they need someone who asks for them, or condensing.
TEST(StorageChoice, LargeStockDracoIsSplitIfItDoesNotGrow) {
  const Mesh flat = make_grid(120, 90);
  std::vector<float> positions = values_of<float>(flat.attributes[0]);
  for (size_t i = 0; i < positions.size(); ++i)
    positions[i] += 0.3f * std::sin(static_cast<float>(i * i % 1009));
  Document stock = document_from_mesh(make_mesh(positions, flat.faces));
  ASSERT_TRUE(encode_document_stock(stock, {}, test_pool()));
  Document document = stock;
  auto reports =
      must(encode_by_default(document, DocumentOptions{.patches = {.min_faces = 10000}, .condense = true}));
  EXPECT_EQ(reports[0].stored_as, StoredAs::kPatches) << reports[0].skipped;
  EXPECT_GT(reports[0].statistics.patch_count, 1u);
  EXPECT_LE(glb_bytes(document), glb_bytes(stock));
  document = stock;
  reports = must(encode_by_default(document, DocumentOptions{.patches = {.count = 2}}));
  EXPECT_EQ(reports[0].stored_as, StoredAs::kPatches) << reports[0].skipped;
  EXPECT_GT(reports[0].bytes, reports[0].input_bytes);
  document = stock;
  reports = must(encode_by_default(document, DocumentOptions{.patches = {.min_faces = 10000}}));
  EXPECT_EQ(reports[0].stored_as, StoredAs::kAsItWas);
  EXPECT_EQ(glb_bytes(document), glb_bytes(stock));
  EXPECT_TRUE(reports[0].skipped.ends_with("in patches; --patches and --patch-faces split it all the same"))
      << reports[0].skipped;
  EXPECT_EQ(document.json(), stock.json());
}

TEST(StorageChoice, WhatDrawsNothingGoesAndIsCounted) {
  Mesh mesh = make_grid(20, 20);
  std::vector<float> positions = values_of<float>(mesh.attributes[0]);
  positions.insert(positions.end(),
                   {50, 50, 50, 0, 0, 0});  // a point without a face, and a point that equals point 0
  mesh.faces.push_back({0, 0, 1});
  mesh.faces.push_back({0, mesh.point_count + 1, 5});  // repeats a point when equal points are merged
  mesh = make_mesh(positions, mesh.faces);
  Document document = document_from_mesh(mesh);
  const auto reports = must(encode_by_default(document));
  EXPECT_EQ(reports[0].stored_as, StoredAs::kDraco);
  EXPECT_EQ(reports[0].statistics.dropped_faces, 2u);
  EXPECT_EQ(reports[0].statistics.dropped_points, 1u);
  EXPECT_EQ(reports[0].statistics.merged_points, 1u);
  Document kept = document_from_mesh(mesh);
  const auto of_kept =
      must(encode_by_default(kept, DocumentOptions{.keep_degenerate = true, .keep_unused = true}));
  EXPECT_EQ(of_kept[0].stored_as, StoredAs::kPatches);  // Edgebreaker cannot code them
  EXPECT_EQ(of_kept[0].statistics.residue_faces, 2u);
  EXPECT_EQ(of_kept[0].statistics.residue_points, 1u);
  EXPECT_EQ(findings_of(kept, draco_backend()), "");
}

TEST(StorageChoice, APrimitiveOfFacesThatEqualPointsMakeDegenerateStays) {
  const Document before = document_from_mesh(make_mesh({0, 0, 0, 0, 0, 0, 0, 1, 0}, {{0, 1, 2}}));
  Document document = before;
  const auto reports = must(encode_by_default(document));
  EXPECT_EQ(reports[0].skipped, "no triangles but degenerate ones");
  EXPECT_EQ(document.json(), before.json());
}

// Two points at the same position are moved apart by a morph target: then their faces are drawn.
TEST(StorageChoice, FacesThatAMorphTargetOpensAreKept) {
  Mesh mesh = make_grid(12, 12);
  std::vector<float> positions = values_of<float>(mesh.attributes[0]);
  std::vector<float> deltas(positions.size(), 0);
  for (const uint32_t point : {20u, 21u, 22u}) {
    const auto copy = static_cast<uint32_t>(positions.size() / 3);
    for (size_t c = 0; c < 3; ++c) positions.push_back(positions[3 * point + c]);
    deltas.insert(deltas.end(), {0, 0, 1});
    mesh.faces.push_back({point, copy, point + 1});
  }
  mesh = make_mesh(positions, mesh.faces);
  for (const bool whole : {true, false}) {
    Document document = document_from_mesh(mesh);
    primitive_of(document)["targets"] =
        Json::array({{{"POSITION", append_accessor(document, make_data(ComponentType::kFloat32, 3, deltas),
                                                   34962, true)}}});
    const EncodeDocumentOptions options =
        DocumentOptions{.patches = {.count = whole ? 1u : 3u}, .lossless = true};
    const auto reports = must(encode_by_default(document, options));
    EXPECT_EQ(reports[0].stored_as, whole ? StoredAs::kDraco : StoredAs::kPatches);
    EXPECT_EQ(reports[0].statistics.dropped_faces, 0u);
    EXPECT_FALSE(reports[0].has_residue);
    EXPECT_EQ(read(document)->faces.size(), mesh.faces.size());
    const auto morphs = must(read_morph_targets(document, {0, 0}));
    const std::vector<float> moved =
        values_of<float>(Attribute{"target", ComponentType::kFloat32, 3, false, morphs[0].data.values});
    EXPECT_GE(std::count(moved.begin(), moved.end(), 1.0f), 3);
  }
}

}  // namespace
}  // namespace psplit
