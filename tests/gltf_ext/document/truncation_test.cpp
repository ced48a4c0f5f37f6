// Files that end early and broken streams are refused, with their place: file, mesh, primitive, patch.
#include <fstream>

#include "psplit/document.h"
#include "src/container/patch_container.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

std::vector<uint8_t> glb_of(const Document& document) {
  const TestFolder folder;
  const fs::path path = folder / "asset.glb";
  EXPECT_TRUE(write_document(document, path).ok());
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// A .gltf whose bytes are in a data URI.
std::vector<uint8_t> gltf_of(const Document& document) {
  Json json = document.json();
  std::string uri = "data:,";
  constexpr std::string_view kHex = "0123456789ABCDEF";
  for (const uint8_t byte : document.buffers[0].bytes()) {
    uri += '%';
    uri += kHex[byte >> 4];
    uri += kHex[byte & 15];
  }
  json["buffers"][0]["uri"] = uri;
  const std::string text = json.dump();
  return {text.begin(), text.end()};
}

void expect_refused(std::span<const uint8_t> bytes, const std::string& name) {
  const Expected<Document> document = parse_document(bytes, "folder/" + name);
  ASSERT_FALSE(document) << bytes.size();
  EXPECT_EQ(document.status().code(), StatusCode::kInvalidInput) << document.status().to_string();
  EXPECT_TRUE(document.status().to_string().starts_with("folder/" + name + ": "))
      << document.status().to_string();
}

TEST(Truncation, EveryOneOfASmallAssetIsRefusedByName) {
  Document document = document_from_mesh(make_grid(3, 3));
  ASSERT_TRUE(encode(document, DocumentOptions{.patches = {.count = 2}}));
  const std::vector<uint8_t> glb = glb_of(document), gltf = gltf_of(document);
  ASSERT_TRUE(parse_document(glb, "a.glb"));
  ASSERT_TRUE(parse_document(gltf, "a.gltf"));
  for (size_t length = 0; length < glb.size(); ++length) expect_refused(std::span(glb).first(length), "a.glb");
  for (size_t length = 0; length < gltf.size(); ++length)
    expect_refused(std::span(gltf).first(length), "a.gltf");
}

TEST(Truncation, SamplesOfALargerAssetAreRefusedByName) {
  Document document = document_from_mesh(rich_mesh(60, 50));
  const std::vector<uint8_t> glb = glb_of(document);
  for (size_t i = 0; i < 200; ++i) expect_refused(std::span(glb).first(glb.size() * i / 200), "large.glb");
}

TEST(Truncation, EveryOneOfAContainerNamesItsPrimitive) {
  Document whole = document_from_mesh(make_grid(6, 6));
  whole.source = "asset.glb";
  ASSERT_TRUE(encode(whole, DocumentOptions{.patches = {.count = 3}}));
  const size_t bytes = buffer_view_bytes(whole, 0)->size();
  for (size_t length = 0; length < bytes; ++length) {
    Document document = whole;
    document.json()["bufferViews"][0]["byteLength"] = length;
    const Status status = decode(document);
    EXPECT_EQ(status.code(), StatusCode::kInvalidInput) << length;
    EXPECT_TRUE(status.to_string().starts_with("asset.glb: mesh 0, primitive 0")) << status.to_string();
  }
}

TEST(Truncation, AStreamThatIsNoneNamesItsPatch) {
  Document whole = document_from_mesh(make_grid(12, 12));
  whole.source = "asset.glb";
  ASSERT_TRUE(encode(whole, DocumentOptions{.patches = {.count = 4}}));
  const PatchContainer container = must(open_container(*buffer_view_bytes(whole, 0)));
  ASSERT_EQ(container.streams.size(), 4u);
  for (size_t patch = 0; patch < 4; ++patch) {
    Document document = whole;
    const auto at = static_cast<size_t>(container.streams[patch].data() - whole.buffers[0].bytes().data());
    document.buffers[0].own()[at] ^= 0xff;
    const Status status = decode(document);
    EXPECT_EQ(status.code(), StatusCode::kInvalidInput);
    const std::string place = "asset.glb: mesh 0, primitive 0, patch " + std::to_string(patch) + ": ";
    EXPECT_TRUE(status.to_string().starts_with(place)) << status.to_string();
  }
}

}  // namespace
}  // namespace psplit
