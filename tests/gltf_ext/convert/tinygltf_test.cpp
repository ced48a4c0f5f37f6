// Another loader, tinygltf, reads the output of psplit.
#include <tiny_gltf.h>

#include "encoder/draco/draco_backend.h"
#include "gltf_ext/convert/decode_document.h"
#include "gltf_ext/convert/document_from_mesh.h"
#include "gltf_ext/convert/encode_document.h"
#include "gltf_ext/document/write_document.h"
#include "gltf_ext/primitive/read_primitives.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// The bytes of an accessor that is tightly packed.
std::span<const uint8_t> packed_bytes(const tinygltf::Model& model, int index) {
  const tinygltf::Accessor& accessor = model.accessors.at(static_cast<size_t>(index));
  const tinygltf::BufferView& view = model.bufferViews.at(static_cast<size_t>(accessor.bufferView));
  const auto size =
      static_cast<size_t>(tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(accessor.componentType)) *
                          tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type)));
  return std::span(model.buffers.at(static_cast<size_t>(view.buffer)).data)
      .subspan(view.byteOffset + accessor.byteOffset, size * accessor.count);
}

tinygltf::Model load(const fs::path& path) {
  tinygltf::TinyGLTF loader;
  tinygltf::Model model;
  std::string error, warning;
  EXPECT_TRUE(loader.LoadBinaryFromFile(&model, &error, &warning, path.string())) << error;
  EXPECT_EQ(error, "");
  return model;
}

class TinyGltfTest : public testing::Test {
 protected:
  TestFolder folder_;
  const fs::path path_ = folder_ / "asset.glb";
  ThreadPool pool_{2};
};

TEST_F(TinyGltfTest, LoadsDecodedAssetsAndFindsTheSameBytes) {
  for (const NamedMesh& sample : procedural_meshes()) {
    SCOPED_TRACE(sample.name);
    Document document = document_from_mesh(sample.mesh);
    const EncodeDocumentOptions options{.patches = {.count = 4, .always = true}};
    ASSERT_TRUE(encode_document(document, options, draco_backend(), pool_));
    ASSERT_TRUE(decode_document(document, draco_backend(), pool_).ok());
    ASSERT_TRUE(write_document(document, path_).ok());
    const Mesh mesh = must(read_primitive(document, {0, 0}, draco_backend(), pool_));

    const tinygltf::Model model = load(path_);
    ASSERT_EQ(model.meshes.size(), 1u);
    const tinygltf::Primitive& primitive = model.meshes[0].primitives.at(0);
    ASSERT_EQ(primitive.attributes.size(), mesh.attributes.size());
    for (const Attribute& attribute : mesh.attributes) {
      const auto bytes = packed_bytes(model, primitive.attributes.at(attribute.semantic));
      ASSERT_EQ(bytes.size(), attribute.values.size());
      EXPECT_EQ(std::memcmp(bytes.data(), attribute.values.data(), bytes.size()), 0) << attribute.semantic;
    }
    EXPECT_EQ(model.accessors.at(static_cast<size_t>(primitive.indices)).count, mesh.faces.size() * 3);
  }
}

// Without a fallback, tinygltf refuses indices without a buffer view, even if an extension supplies them.
TEST_F(TinyGltfTest, OpensTheFallbackOfAnEncodedAsset) {
  Document document = document_from_mesh(make_grid(20, 20));
  const EncodeDocumentOptions options{.patches = {.always = true}, .fallback = Fallback::kUncompressed};
  ASSERT_TRUE(encode_document(document, options, draco_backend(), pool_));
  ASSERT_TRUE(write_document(document, path_).ok());
  const tinygltf::Model model = load(path_);
  EXPECT_TRUE(model.extensionsRequired.empty());
  const tinygltf::Primitive& primitive = model.meshes.at(0).primitives.at(0);
  EXPECT_TRUE(primitive.extensions.contains(kExtensionName));
  EXPECT_EQ(packed_bytes(model, primitive.attributes.at("POSITION")).size(), 21u * 21u * 12u);
}

}  // namespace
}  // namespace psplit
