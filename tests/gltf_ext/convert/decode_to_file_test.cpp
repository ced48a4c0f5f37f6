// A document that may not be decoded in memory becomes the same file as one that may.

#include "gltf_ext/convert/stated_bytes.h"
#include "psplit/decode.h"
#include "psplit/document.h"
#include "system/files.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

class DecodeToFile : public testing::Test {
 protected:
  // Decodes with little memory and with enough, and compares the outputs.
  void expect_same_output(const Document& document) {
    Document whole = document;
    ASSERT_TRUE(decode_document(whole, cpu_backend(), test_pool()).ok());
    for (const uint64_t memory : {uint64_t{1}, uint64_t{20000}, uint64_t{1} << 40}) {
      Document windows = document;
      must(decode_document(windows, cpu_backend(), test_pool(), {}, MemoryLimit{memory, folder_}));
      EXPECT_EQ(windows.buffers.back().is_shared(), memory < uint64_t{1} << 40);
      for (const std::string name : {"out.glb", "out.gltf"}) {
        ASSERT_TRUE(write_document(whole, folder_ / name).ok());
        const std::vector<std::vector<uint8_t>> expected = files();
        ASSERT_TRUE(write_document(windows, folder_ / name).ok());
        EXPECT_EQ(files(), expected) << memory << " " << name;
      }
    }
  }
  std::vector<std::vector<uint8_t>> files() const {
    std::vector<std::filesystem::path> paths;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    std::vector<std::vector<uint8_t>> contents;
    for (const auto& path : paths) contents.push_back(*read_file(path));
    return contents;
  }

  TestFolder folder_;
};

TEST_F(DecodeToFile, GivesTheSameOutput) {
  for (const size_t filler : {0u, 4u, 8u}) {  // the place of the container in its buffer
    Document document = document_from_mesh(rich_mesh(40, 30));
    if (filler > 0) {
      append_buffer_view(document, std::vector<uint8_t>(filler, 7));
      document.json()["images"] = Json::array({{{"mimeType", "image/png"}, {"bufferView", 0}}});
      document.json()["images"][0]["bufferView"] = document.json()["bufferViews"].size() - 1;
    }
    ASSERT_TRUE(encode(document, DocumentOptions{.patches = {.count = 9}}).ok());
    expect_same_output(document);
  }
}

TEST_F(DecodeToFile, GivesTheSameOutputForManyPrimitivesInAllForms) {
  Document document = document_from_mesh(rich_mesh(30, 20));
  const Json primitive = primitive_of(document);
  document.json()["meshes"] = Json::array();
  for (int i = 0; i < 4; ++i)
    document.json()["meshes"].push_back({{"primitives", Json::array({primitive, primitive})}});
  Json other = primitive;  // has the positions of `primitive`, and no other attributes
  other["attributes"] = {{"POSITION", primitive["attributes"]["POSITION"]}};
  document.json()["meshes"][1]["primitives"][0] = other;
  Json points = primitive;
  points["mode"] = 0;
  document.json()["meshes"][2]["primitives"][1] = points;
  ASSERT_TRUE(encode(document, DocumentOptions{.patches = {.count = 5}, .condense = true}).ok());
  expect_same_output(document);
}

// They are decoded one after the other, between containers that are decoded window by window.
TEST_F(DecodeToFile, GivesTheSameOutputForStockDraco) {
  Document document = document_from_mesh(rich_mesh(20, 10));
  for (const uint32_t columns : {25u, 30u, 35u}) add_mesh(document, rich_mesh(columns, 10));
  // All of them become stock Draco.
  const EncodeDocumentOptions options = DocumentOptions{.patches = {.faces = 500}, .compat = Compat::kKhr};
  ASSERT_TRUE(encode_document(document, options, reference_backend(), test_pool()).ok());
  expect_same_output(document);
}

TEST_F(DecodeToFile, TheDocumentStatesTheBytes) {
  for (const bool in_patches : {true, false}) {
    Document document = document_from_mesh(rich_mesh(40, 30));
    const EncodeDocumentOptions options = DocumentOptions{.patches = {.count = in_patches ? 4u : 1u},
                                                          .compat = in_patches ? Compat::kNone : Compat::kKhr};
    ASSERT_TRUE(encode(document, options).ok());
    const StatedBytes stated = stated_bytes(document);
    EXPECT_GT(stated.stored, 1000u);
    ASSERT_TRUE(decode(document).ok());
    EXPECT_LE(stated.decoded, document.buffers[0].size()) << in_patches;
    EXPECT_GT(stated.decoded + 8, document.buffers[0].size()) << in_patches;  // bytes move in blocks of 8
    EXPECT_EQ(stated_bytes(document).decoded, 0u);
  }
  // A count that the stored bytes do not justify is an error of decoding.
  Document document = document_from_mesh(rich_mesh(40, 30));
  ASSERT_TRUE(encode(document).ok());
  accessor_of(document, "POSITION")["count"] = 4000000000;
  EXPECT_EQ(stated_bytes(document).decoded, 0u);
}

TEST_F(DecodeToFile, ABufferKeepsItsName) {
  for (const uint64_t memory : {uint64_t{0}, uint64_t{1}}) {
    Document document = document_from_mesh(rich_mesh());
    document.json()["buffers"][0]["name"] = "geometry";
    ASSERT_TRUE(encode(document, DocumentOptions{.patches = {.count = 4}}).ok());
    ASSERT_TRUE(decode_document(document, cpu_backend(), test_pool(), {}, MemoryLimit{memory, folder_}).ok());
    const Json& buffers = std::as_const(document).json()["buffers"];
    ASSERT_EQ(buffers.size(), 1u);
    EXPECT_EQ(buffers[0].value("name", ""), "geometry");
  }
}

TEST_F(DecodeToFile, GivesTheSameErrors) {
  Document document = document_from_mesh(rich_mesh());
  ASSERT_TRUE(encode(document, DocumentOptions{.patches = {.count = 4}}).ok());
  document.source = "asset.glb";
  // Whether the document is refused.
  const auto expect_same_error = [&](const Document& broken) {
    Document whole = broken, windows = broken;
    const Status expected = decode_document(whole, cpu_backend(), test_pool());
    EXPECT_EQ(decode_document(windows, cpu_backend(), test_pool(), {}, MemoryLimit{1, folder_}).to_string(),
              expected.to_string());
    return !expected.ok();
  };
  Document count = document;
  accessor_of(count, "POSITION")["count"] = 1;
  EXPECT_TRUE(expect_same_error(count));
  Document bounds = document;
  accessor_of(bounds, "POSITION")["min"][0] = -99;
  EXPECT_TRUE(expect_same_error(bounds));
  size_t refused = 0;
  for (const size_t from_end : {10u, 300u, 900u}) {
    Document stream = document;
    std::vector<uint8_t>& bytes = stream.buffers[0].own();
    std::fill_n(bytes.end() - static_cast<std::ptrdiff_t>(from_end), 10, uint8_t{0xff});
    refused += expect_same_error(stream);
  }
  EXPECT_GT(refused, 0u);  // 0xff may also be other values of a valid stream
}

TEST_F(DecodeToFile, SaysThatTheFolderIsMissing) {
  Document document = document_from_mesh(rich_mesh());
  ASSERT_TRUE(encode(document).ok());
  const Status status =
      decode_document(document, cpu_backend(), test_pool(), {}, MemoryLimit{1, folder_ / "missing"});
  EXPECT_EQ(status.code(), StatusCode::kIo) << status.to_string();
}

}  // namespace
}  // namespace psplit
