// What extras and unknown extensions may name keeps its number and its data, whatever is done to the geometry.
#include "gltf_ext/document/unknown_references.h"

#include "psplit/document.h"
#include "psplit/gltf.h"
#include "tests/gltf_ext/asset.h"

namespace psplit {
namespace {

using Indices = std::set<int64_t>;

UnknownReferences found_in(const char* json) { return find_unknown_references(Json::parse(json)); }

TEST(UnknownReferences, NamesOfMembersTell) {
  const UnknownReferences extras = found_in(R"({"nodes": [
      {"extras": {"bufferView": 7, "data": {"view": 2}, "accessor": 3, "my_accessors": [4, 5], "id": 1, "mesh": 0}},
      {"extras": {"buffer": 6, "preview": 8, "accessor": {"count": 9, "type": 9, "x": 10}}},
      {"extras": {"values": 11}, "accessorOfMine": 12}]})");
  EXPECT_EQ(extras.accessors, (Indices{3, 4, 5, 10, 12}));
  EXPECT_EQ(extras.views, (Indices{2, 7}));
  EXPECT_EQ(extras.buffers, (Indices{6}));
  EXPECT_FALSE(extras.has_unknown_extensions);

  const UnknownReferences extension = found_in(R"({"meshes": [{"primitives": [{
      "attributes": {"POSITION": 20}, "indices": 21, "extensions": {
          "ACME_shape": {"indices": 5, "attributes": {"A": 3}, "mesh": 0, "values": 8, "positions": [9]},
          "KHR_materials_variants": {"mappings": [{"material": 1, "variants": [2], "extras": {"accessor": 4}}]}}}]}]})");
  EXPECT_EQ(extension.accessors, (Indices{3, 4, 5, 8}));
  EXPECT_EQ(extension.views, (Indices{8}));
  EXPECT_TRUE(extension.has_unknown_extensions);

  const UnknownReferences ordinary = found_in(R"({"accessors": [{"bufferView": 1, "sparse": {"indices": {}}}],
      "skins": [{"inverseBindMatrices": 2}], "animations": [{"samplers": [{"input": 3, "output": 4}]}],
      "materials": [{"extensions": {"KHR_materials_ior": {"ior": 1}}}], "extensions": {"ACME_x": {"mesh": 0}}})");
  EXPECT_TRUE(ordinary.accessors.empty() && ordinary.views.empty() && ordinary.buffers.empty());
}

std::vector<uint8_t> view_bytes(const Document& document, int64_t view) {
  const auto bytes = must(buffer_view_bytes(document, view));
  return {bytes.begin(), bytes.end()};
}

TEST(UnknownReferences, NamedAccessorsAndViewsStayThroughEncodeAndDecode) {
  for (const char* extras :
       {R"({"accessor": 0})", R"({"deep": [{"accessors": [0]}]})", R"({"bufferView": 0})"}) {
    SCOPED_TRACE(extras);
    Document document = document_from_mesh(make_grid(30, 20));
    document.json()["nodes"][0]["extras"] = Json::parse(extras);
    const bool is_accessor = std::string(extras).find("accessor") != std::string::npos;
    const Array<std::byte> values = must(read_accessor(document, 0)).values;
    const std::vector<uint8_t> bytes = view_bytes(document, 0);
    const auto expect_same = [&] {
      EXPECT_EQ(view_bytes(document, 0), bytes);
      if (is_accessor) {
        EXPECT_EQ(must(read_accessor(document, 0)).values, values);
      }
      EXPECT_EQ(findings_of(document, reference_backend()), "");
    };
    must(encode(document).status());
    ASSERT_EQ(count_in(document, kExtensionName), 3u);
    expect_same();
    must(decode(document));
    ASSERT_EQ(count_in(document, kExtensionName), 0u);
    expect_same();
  }
}

TEST(UnknownReferences, APrimitiveWithAnUnknownExtensionThatNamesAccessorsStays) {
  for (const bool of_mesh : {false, true}) {
    Document document = document_from_mesh(make_grid(30, 20));
    Json& holder = of_mesh ? document.json()["meshes"][0] : primitive_of(document);
    holder["extensions"]["ACME_outline"] = {{"indices", 1}, {"style", "thick"}};
    document.json()["extensionsUsed"] = Json::array({"ACME_outline"});
    const Json before = document.json();
    const auto reports = must(encode(document));
    EXPECT_EQ(reports[0].skipped,
              "ACME_outline is unknown and may name accessors; --drop-extension ACME_outline removes it");
    EXPECT_EQ(document.json()["accessors"], before["accessors"]);
    EXPECT_EQ(document.json()["meshes"], before["meshes"]);
  }
}

TEST(UnknownReferences, IndicesOfOtherObjectsKeepNoGeometry) {
  const auto bytes_with = [](const char* extension) {
    Document document = document_from_mesh(make_grid(30, 20));
    if (extension != nullptr) document.json()["extensions"]["ACME_x"] = Json::parse(extension);
    must(encode(document).status());
    return document.buffers[0].size();
  };
  const size_t wanted = bytes_with(nullptr);
  for (const char* extension : {R"({"mesh": 0})", R"({"items": [{"id": 0}, {"node": 1}]})", R"({"index": 0})"})
    EXPECT_LE(bytes_with(extension), wanted + 32) << extension;  // some bytes for views that keep their numbers
  EXPECT_GT(bytes_with(R"({"accessor": 0})"), wanted + 1000);
}

TEST(UnknownReferences, ExpandLeavesANamedContainer) {
  Document document = document_from_mesh(make_grid(60, 40));
  EncodeDocumentOptions options;
  options.condense = Condense::kFast;
  options.patches.always = true;
  options.patches.count = 4;
  must(encode(document, options).status());
  const auto view = primitive_of(document)["extensions"][kExtensionName]["bufferView"].get<int64_t>();
  document.json()["extras"] = {{"bufferView", view}};
  const std::vector<uint8_t> bytes = view_bytes(document, view);
  const Mesh before = must(read(document));
  const auto report = must(expand_document(document, cpu_backend(), test_pool()));
  EXPECT_EQ(report.to_patches, 1u);
  EXPECT_EQ(view_bytes(document, view), bytes);
  EXPECT_NE(primitive_of(document)["extensions"][kExtensionName]["bufferView"], view);
  EXPECT_EQ(must(read(document)).faces.size(), before.faces.size());
  EXPECT_EQ(findings_of(document, reference_backend()), "");
}

}  // namespace
}  // namespace psplit
