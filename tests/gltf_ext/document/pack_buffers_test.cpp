// Many buffers become one or two, and every view keeps its bytes.
#include "gltf_ext/document/pack_buffers.h"

#include "gltf_ext/document/byte_runs.h"
#include "psplit/document.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

std::string view_bytes(const Document& document, size_t view) {
  const auto bytes = buffer_view_bytes(document, static_cast<int64_t>(view));
  return bytes ? std::string(bytes->begin(), bytes->end()) : bytes.status().message();
}

// Writes a .gltf and reads it again.
Document again(const Document& document, const TestFolder& folder) {
  EXPECT_TRUE(write_document(document, folder / "asset.gltf").ok());
  return must(read_document(folder / "asset.gltf"));
}

void expect_same_views(const Document& before, const Document& after) {
  ASSERT_EQ(after.json()["bufferViews"].size(), before.json()["bufferViews"].size());
  for (size_t i = 0; i < before.json()["bufferViews"].size(); ++i)
    EXPECT_EQ(view_bytes(after, i), view_bytes(before, i)) << i;
}

size_t buffer_of_accessor(const Document& document, const Json& index) {
  const Json& accessor = document.json()["accessors"][index.get<size_t>()];
  return document.json()["bufferViews"][accessor["bufferView"].get<size_t>()]["buffer"].get<size_t>();
}

Document with_fallback() {
  Document document = document_from_mesh(rich_mesh());
  EXPECT_TRUE(encode(document, DocumentOptions{.patches = {.count = 3}, .fallback = Fallback::kUncompressed}));
  return document;
}

TEST(PackBuffers, AFallbackGoesToABufferOfItsOwn) {
  const Document document = with_fallback();
  const TestFolder folder;
  const Document written = again(document, folder);
  expect_same_views(document, written);
  ASSERT_EQ(written.buffers.size(), 2u);
  const Json& primitive = written.json()["meshes"][0]["primitives"][0];
  EXPECT_EQ(buffer_of_accessor(written, primitive["indices"]), 1u);
  for (const auto& [semantic, index] : primitive["attributes"].items())
    EXPECT_EQ(buffer_of_accessor(written, index), 1u) << semantic;
  EXPECT_EQ(written.json()["bufferViews"][primitive["extensions"][kExtensionName]["bufferView"].get<size_t>()]
                          ["buffer"],
            0);
  EXPECT_EQ(pack_buffers(document, false).fallback.size(), 0u);
}

TEST(PackBuffers, WhatOthersReadAsWellStaysInTheFirst) {
  Document document = with_fallback();
  const Json attributes = primitive_of(document)["attributes"];
  // A second mesh uses one accessor, an image uses the view of another, and a view covers the bytes of a third
  // and more.
  document.json()["meshes"].push_back(
      {{"primitives", Json::array({{{"attributes", {{"POSITION", attributes["POSITION"]}}}, {"mode", 0}}})}});
  const auto view_of = [&](const char* semantic) {
    return document.json()["accessors"][attributes[semantic].get<size_t>()]["bufferView"].get<size_t>();
  };
  document.json()["images"] = Json::array({{{"bufferView", view_of("NORMAL")}, {"mimeType", "image/png"}}});
  Json across = document.json()["bufferViews"][view_of("TEXCOORD_0")];
  across.erase("byteStride");
  across["byteOffset"] = across["byteOffset"].get<size_t>() + 12;
  document.json()["images"].push_back(
      {{"bufferView", document.json()["bufferViews"].size()}, {"mimeType", "image/png"}});
  document.json()["bufferViews"].push_back(across);
  const TestFolder folder;
  const Document written = again(document, folder);
  expect_same_views(document, written);
  EXPECT_EQ(buffer_of_accessor(written, attributes["POSITION"]), 0u);
  EXPECT_EQ(buffer_of_accessor(written, attributes["NORMAL"]), 0u);
  EXPECT_EQ(buffer_of_accessor(written, attributes["TEXCOORD_0"]), 1u);
  EXPECT_EQ(buffer_of_accessor(written, attributes["TANGENT"]), 1u);
}

TEST(PackBuffers, NamesThatAreLostAreSaid) {
  Document document;
  document.json() = Json::parse(
      R"({"asset":{"version":"2.0"},
          "buffers":[{"byteLength":3,"name":"first"},{"byteLength":2,"name":"second","extras":1},{"byteLength":1}],
          "bufferViews":[{"buffer":0,"byteLength":3},{"buffer":1,"byteLength":2},{"buffer":2,"byteLength":1}]})");
  document.buffers = {std::vector<uint8_t>{1, 2, 3}, std::vector<uint8_t>{4, 5}, std::vector<uint8_t>{6}};
  PackedDocument packed = pack_buffers(document, true);
  list_buffers(packed);
  EXPECT_EQ(packed.json["buffers"][0]["name"], "first");
  ASSERT_EQ(packed.warnings.size(), 1u);
  EXPECT_EQ(packed.warnings[0], "buffer 1 becomes a part of another buffer and loses its name, extras");
  const TestFolder folder;
  expect_same_views(document, again(document, folder));
}

TEST(ByteRuns, KeepBlocksAndCloseGaps) {
  ByteRuns runs(100);
  runs.keep(90, 100);
  runs.keep(9, 12);
  runs.keep(17, 30);
  runs.keep(50, 50);
  runs.close();
  ASSERT_EQ(runs.runs().size(), 2u);  // 8 to 32 and 88 to 100
  EXPECT_EQ(runs.packed_bytes(), 24u + 12);
  EXPECT_EQ(runs.packed(9), 1u);
  EXPECT_EQ(runs.packed(31), 23u);
  EXPECT_EQ(runs.packed(90), 26u);
  EXPECT_EQ(runs.packed(50), 0u) << "gone";
}

}  // namespace
}  // namespace psplit
