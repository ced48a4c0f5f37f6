// A document that may not be decoded in memory becomes the same file as one that may.
#include <fstream>

#include "gltf_ext/convert/document_from_mesh.h"
#include "gltf_ext/document/write_document.h"
#include "gltf_ext/files/files.h"
#include "src/cpu/cpu_backend.h"
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
      const Status status =
          decode_document(windows, cpu_backend(), test_pool(), {}, MemoryLimit{memory, folder_});
      ASSERT_TRUE(status.ok()) << status.to_string();
      EXPECT_EQ(windows.buffers.back().is_mapped(), memory < uint64_t{1} << 40);
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
      document.json["images"] = Json::array({{{"mimeType", "image/png"}, {"bufferView", 0}}});
      document.json["images"][0]["bufferView"] = document.json["bufferViews"].size() - 1;
    }
    EncodeDocumentOptions options;
    options.patches = 9;
    ASSERT_TRUE(encode(document, options).ok());
    expect_same_output(document);
  }
}

TEST_F(DecodeToFile, GivesTheSameOutputForManyPrimitivesInAllForms) {
  Document document = document_from_mesh(rich_mesh(30, 20));
  const Json primitive = primitive_of(document);
  document.json["meshes"] = Json::array();
  for (int i = 0; i < 4; ++i)
    document.json["meshes"].push_back({{"primitives", Json::array({primitive, primitive})}});
  Json other = primitive;  // the same positions without the other attributes
  other["attributes"] = {{"POSITION", primitive["attributes"]["POSITION"]}};
  document.json["meshes"][1]["primitives"][0] = other;
  Json points = primitive;
  points["mode"] = 0;
  document.json["meshes"][2]["primitives"][1] = points;
  EncodeDocumentOptions options;
  options.patches = 5;
  options.condense = true;
  ASSERT_TRUE(encode(document, options).ok());
  expect_same_output(document);
}

TEST_F(DecodeToFile, GivesTheSameErrors) {
  Document document = document_from_mesh(rich_mesh());
  EncodeDocumentOptions options;
  options.patches = 4;
  ASSERT_TRUE(encode(document, options).ok());
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
