#include <atomic>
#include <fstream>

#include "psplit/document.h"
#include "psplit/tinygltf.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/corpus_folder.h"
#include "tests/support/older_stream.h"
#include "tests/support/same_bits.h"
#include "tests/support/test_folder.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kName = "PSPLIT_mesh_draco_patches";

std::vector<uint8_t> bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

bool parse(const fs::path& path, tinygltf::Model& model, std::string& error, bool with_callbacks = true) {
  tinygltf::TinyGLTF loader;
  if (with_callbacks) loader.SetFsCallbacks(tinygltf_file_callbacks());
  std::string warning;
  return path.extension() == ".glb" ? loader.LoadBinaryFromFile(&model, &error, &warning, path.string())
                                    : loader.LoadASCIIFromFile(&model, &error, &warning, path.string());
}

tinygltf::Model parsed(const fs::path& path, bool with_callbacks = true) {
  tinygltf::Model model;
  std::string error;
  EXPECT_TRUE(parse(path, model, error, with_callbacks)) << error;
  return model;
}

// The values of an accessor without strides and padding. Empty if it has no buffer view.
std::vector<std::byte> values_of(const tinygltf::Model& model, int index) {
  const tinygltf::Accessor& accessor = model.accessors.at(static_cast<size_t>(index));
  if (accessor.bufferView < 0) return {};
  const tinygltf::BufferView& view = model.bufferViews.at(static_cast<size_t>(accessor.bufferView));
  const std::vector<unsigned char>& data = model.buffers.at(static_cast<size_t>(view.buffer)).data;
  EXPECT_LE(view.byteOffset + view.byteLength, data.size());
  const size_t component = component_bytes(static_cast<ComponentType>(accessor.componentType));
  const auto count =
      static_cast<size_t>(tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type)));
  const size_t columns = count == 9 ? 3 : count == 16 ? 4 : accessor.type == TINYGLTF_TYPE_MAT2 ? 2 : 1;
  const size_t column = count / columns * component, padded = columns == 1 ? column : (column + 3) / 4 * 4;
  const size_t stride = view.byteStride == 0 ? columns * padded : view.byteStride;
  std::vector<std::byte> values;
  for (size_t i = 0; i < accessor.count; ++i)
    for (size_t c = 0; c < columns; ++c)
      for (size_t byte = 0; byte < column; ++byte) {
        const size_t at = accessor.byteOffset + i * stride + c * padded + byte;
        EXPECT_LT(at, view.byteLength);
        values.push_back(static_cast<std::byte>(data.at(view.byteOffset + at)));
      }
  return values;
}

Mesh mesh_of(const tinygltf::Model& model, size_t mesh = 0, size_t primitive = 0) {
  const tinygltf::Primitive& from = model.meshes.at(mesh).primitives.at(primitive);
  Mesh result;
  for (const auto& [semantic, index] : from.attributes) {
    const tinygltf::Accessor& accessor = model.accessors.at(static_cast<size_t>(index));
    const auto components = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type));
    Attribute attribute{semantic,
                        static_cast<ComponentType>(accessor.componentType),
                        static_cast<uint8_t>(components),
                        accessor.normalized,
                        {}};
    const std::vector<std::byte> values = values_of(model, index);
    attribute.values.assign(values.begin(), values.end());
    result.point_count = static_cast<uint32_t>(accessor.count);
    result.attributes.push_back(std::move(attribute));
  }
  if (from.indices < 0) return result;
  const tinygltf::Accessor& accessor = model.accessors.at(static_cast<size_t>(from.indices));
  const size_t width = component_bytes(static_cast<ComponentType>(accessor.componentType));
  const std::vector<std::byte> indices = values_of(model, from.indices);
  result.faces.assign((accessor.count + 2) / 3, {});  // some assets have lines as well
  for (size_t i = 0; i < accessor.count; ++i)
    std::memcpy(&result.faces[i / 3][i % 3], &indices[i * width], width);
  return result;
}

// Attributes in the order of their names, as in tinygltf.
bool same(Mesh a, Mesh b) {
  const auto by_name = [](const Attribute& x, const Attribute& y) { return x.semantic < y.semantic; };
  std::sort(a.attributes.begin(), a.attributes.end(), by_name);
  std::sort(b.attributes.begin(), b.attributes.end(), by_name);
  if (!same_bits(a, b)) return false;
  for (size_t k = 0; k < a.attributes.size(); ++k)
    if (a.attributes[k].semantic != b.attributes[k].semantic ||
        a.attributes[k].component_type != b.attributes[k].component_type ||
        a.attributes[k].normalized != b.attributes[k].normalized)
      return false;
  return true;
}

void expect_plain(const tinygltf::Model& model) {
  for (const char* name : {"PSPLIT_mesh_draco_patches", "KHR_draco_mesh_compression"}) {
    for (const auto* list : {&model.extensionsUsed, &model.extensionsRequired})
      EXPECT_EQ(std::count(list->begin(), list->end(), name), 0);
    for (const tinygltf::Mesh& mesh : model.meshes)
      for (const tinygltf::Primitive& primitive : mesh.primitives)
        EXPECT_FALSE(primitive.extensions.contains(name));
  }
}

class TinyGltfPlugin : public testing::Test {
 protected:
  TestFolder folder_;

  fs::path write(const Document& document, const char* name = "asset.glb") {
    must(write_document(document, folder_ / name));
    return folder_ / name;
  }
  static Document encoded(const Mesh& mesh, Fallback fallback = Fallback::kNone, bool condense = false) {
    Document document = document_from_mesh(mesh);
    encode_in_place(document, fallback, condense);
    return document;
  }
  static void encode_in_place(Document& document, Fallback fallback = Fallback::kNone, bool condense = false) {
    const EncodeDocumentOptions options =
        DocumentOptions{.patches = {.count = 5, .always = true}, .fallback = fallback, .condense = condense};
    const auto reports = must(encode_document(document, options, draco_backend(), test_pool()));
  }
};

TEST_F(TinyGltfPlugin, MakesThePlainModelThatTheFileWas) {
  std::vector<NamedMesh> meshes = procedural_meshes();
  meshes.push_back({"rich", rich_mesh()});
  for (const NamedMesh& sample : meshes) {
    SCOPED_TRACE(sample.name);
    Document document = encoded(sample.mesh);
    const Mesh expected = must(read(document));
    for (const char* name : {"asset.glb", "asset.gltf"}) {
      tinygltf::Model model = parsed(write(document, name));
      must(decode_model(model));
      expect_plain(model);
      EXPECT_TRUE(same(mesh_of(model), expected));
      // tinygltf writes the model to a file that can be read again.
      tinygltf::TinyGLTF writer;
      const fs::path plain = folder_ / "plain.gltf";
      ASSERT_TRUE(writer.WriteGltfSceneToFile(&model, plain.string(), false, true, true, false));
      const Document again = must(read_document(plain));
      const Mesh read_again = must(read(again));
      EXPECT_TRUE(same(read_again, expected));
    }
    // tinygltf alone reads what psplit has decoded.
    must(decode(document));
    EXPECT_TRUE(same(mesh_of(parsed(write(document), false)), expected));
  }
}

// The constraint that makes tinygltf_file_callbacks necessary.
TEST_F(TinyGltfPlugin, TinyGltfAloneRefusesIndicesWithoutABufferView) {
  const fs::path path = write(encoded(make_grid(20, 20)));
  tinygltf::Model model;
  std::string error;
  EXPECT_FALSE(parse(path, model, error, false));
  EXPECT_TRUE(contains(error, "bufferView"));
}

TEST_F(TinyGltfPlugin, DecodesCondensedPatchesLikeOthers) {
  for (const Mesh& mesh : {make_grid(80, 60), rich_mesh(80, 60)}) {
    const Document condensed = encoded(mesh, Fallback::kNone, true);
    const Document plain = encoded(mesh);
    EXPECT_LT(stored_primitive(condensed, {0, 0})->bytes.size(), stored_primitive(plain, {0, 0})->bytes.size());
    tinygltf::Model model = parsed(write(condensed));
    must(decode_model(model));
    EXPECT_TRUE(same(mesh_of(model), *read(plain)));
  }
}

TEST_F(TinyGltfPlugin, PreparesFilesInMemory) {
  const Document document = encoded(make_grid(20, 20));
  const Expected<Mesh> expected = read(document);
  std::vector<uint8_t> file = bytes_of(write(document));
  ASSERT_TRUE(prepare_for_tinygltf(file).ok());
  std::vector<uint8_t> twice = file;
  ASSERT_TRUE(prepare_for_tinygltf(twice).ok());
  EXPECT_EQ(twice, file);
  tinygltf::TinyGLTF loader;
  tinygltf::Model model;
  std::string error, warning;
  ASSERT_TRUE(
      loader.LoadBinaryFromMemory(&model, &error, &warning, file.data(), static_cast<unsigned>(file.size())))
      << error;
  ASSERT_TRUE(decode_model(model).ok());
  EXPECT_TRUE(same(mesh_of(model), *expected));
}

TEST_F(TinyGltfPlugin, PreparingLeavesAllElseAlone) {
  const auto unchanged = [](std::vector<uint8_t> file) {
    const std::vector<uint8_t> before = file;
    const Status status = prepare_for_tinygltf(file);
    EXPECT_EQ(file, before);
    return status;
  };
  EXPECT_TRUE(unchanged({}).ok());
  EXPECT_TRUE(unchanged({'{', '}', 0, 1}).ok());
  EXPECT_TRUE(unchanged(bytes_of(write(document_from_mesh(make_grid(2, 2))))).ok());
  EXPECT_TRUE(unchanged(bytes_of(write(encoded(make_grid(2, 2), Fallback::kUncompressed)))).ok());
  const std::string broken = "{ \"PSPLIT_mesh_draco_patches\": ";
  EXPECT_EQ(unchanged({broken.begin(), broken.end()}).code(), StatusCode::kInvalidInput);
  std::vector<uint8_t> file = bytes_of(write(encoded(make_grid(2, 2))));
  for (size_t length = 4; length < file.size(); ++length)  // shorter ones are no GLB
    EXPECT_FALSE(unchanged({file.begin(), file.begin() + static_cast<ptrdiff_t>(length)}).ok()) << length;
}

TEST_F(TinyGltfPlugin, DecodesOverAFallback) {
  const Document document = encoded(rich_mesh(), Fallback::kUncompressed);
  const Expected<Mesh> expected = read(document);
  tinygltf::Model model = parsed(write(document), false);
  EXPECT_TRUE(same(mesh_of(model), *expected));
  EXPECT_TRUE(model.extensionsRequired.empty());
  EXPECT_TRUE(model.meshes[0].primitives[0].extensions.contains(kName));
  // The fallback holds the same data as the patches. A spoilt one shows which of the two was read.
  for (const tinygltf::Accessor& accessor : model.accessors) {
    ASSERT_GE(accessor.bufferView, 0);
    const tinygltf::BufferView& view = model.bufferViews[static_cast<size_t>(accessor.bufferView)];
    std::vector<unsigned char>& bytes = model.buffers[static_cast<size_t>(view.buffer)].data;
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(view.byteOffset), view.byteLength, uint8_t{0});
  }
  EXPECT_FALSE(same(mesh_of(model), *expected));
  must(decode_model(model));
  expect_plain(model);
  EXPECT_TRUE(same(mesh_of(model), *expected));
}

TEST_F(TinyGltfPlugin, DecodesWhatReplacesCoarsePrimitives) {
  const Document document = encoded(rich_mesh(60, 50), Fallback::kCoarse);
  const Expected<Mesh> expected = read(document);
  for (const char* name : {"asset.glb", "asset.gltf"}) {
    const fs::path path = write(document, name);
    tinygltf::Model model = parsed(path);
    must(decode_model(model));
    expect_plain(model);
    EXPECT_TRUE(same(mesh_of(model), *expected));
    // tinygltf alone reads the coarse ones, and cannot be given the others any more.
    tinygltf::Model coarse = parsed(path, false);
    EXPECT_LT(mesh_of(coarse).faces.size(), expected->faces.size() / 2);
    EXPECT_EQ(decode_model(coarse).code(), StatusCode::kInvalidInput);
  }
}

// Columns of 8-bit matrices are padded in a buffer view.
TEST_F(TinyGltfPlugin, SpreadsColumnsOfMatrices) {
  Mesh mesh = make_grid(9, 7);
  std::vector<uint8_t> three, two;
  std::vector<uint16_t> wide;
  for (uint32_t i = 0; i < mesh.point_count * 9; ++i) {
    three.push_back(static_cast<uint8_t>(i * 5));
    wide.push_back(static_cast<uint16_t>(i * 77));
  }
  mesh.attributes.push_back(make_attribute("_THREE", ComponentType::kUint8, 9, false, three));
  mesh.attributes.push_back(make_attribute("_WIDE", ComponentType::kUint16, 9, false, wide));
  const Document document = encoded(mesh);
  const Mesh expected = must(read(document));
  tinygltf::Model model = parsed(write(document));
  must(decode_model(model));
  EXPECT_TRUE(same(mesh_of(model), expected));
}

TEST_F(TinyGltfPlugin, EqualPrimitivesAreDecodedOnceAndOthersKeepTheirAccessors) {
  Document document = encoded(make_grid(20, 20));
  const Expected<Mesh> expected = read(document);
  document.json()["meshes"][0]["primitives"].push_back(document.json()["meshes"][0]["primitives"][0]);
  document.json()["meshes"].push_back(document.json()["meshes"][0]);
  tinygltf::Model model = parsed(write(document));
  // An animation that uses the positions. It keeps its accessor.
  const int positions = model.meshes[0].primitives[0].attributes.at("POSITION");
  const size_t accessor_count = model.accessors.size(), view_count = model.bufferViews.size();
  tinygltf::Model shared = model;
  shared.animations.emplace_back();
  shared.animations[0].samplers.emplace_back();
  shared.animations[0].samplers[0].input = positions;
  ASSERT_TRUE(decode_model(model).ok());
  EXPECT_EQ(model.accessors.size(), accessor_count);
  EXPECT_EQ(model.bufferViews.size(), view_count + 2);
  for (size_t mesh = 0; mesh < 2; ++mesh)
    for (size_t primitive = 0; primitive < 2; ++primitive)
      EXPECT_TRUE(same(mesh_of(model, mesh, primitive), *expected));
  ASSERT_TRUE(decode_model(shared).ok());
  EXPECT_EQ(shared.accessors.size(), accessor_count + 1);
  EXPECT_EQ(shared.accessors[static_cast<size_t>(positions)].bufferView, -1);
  EXPECT_TRUE(same(mesh_of(shared, 1, 1), *expected));
}

TEST_F(TinyGltfPlugin, PrimitivesWithoutIndicesGetSome) {
  const Document document = encoded(make_grid(20, 20));
  const Expected<Mesh> expected = read(document);
  tinygltf::Model model = parsed(write(document));
  model.meshes[0].primitives[0].indices = -1;
  ASSERT_TRUE(decode_model(model).ok());
  EXPECT_TRUE(same(mesh_of(model), *expected));
}

TEST_F(TinyGltfPlugin, NamesMeshPrimitiveAndPatchAndLeavesTheModel) {
  Document document = encoded(make_grid(40, 40));
  document.json()["meshes"].push_back(document.json()["meshes"][0]);
  const tinygltf::Model good = parsed(write(document));
  const auto expect_refused = [&](auto change, const std::string& said, StatusCode code) {
    tinygltf::Model model = good;
    change(model);
    const tinygltf::Model before = model;
    const Status status = decode_model(model);
    EXPECT_EQ(status.code(), code);
    EXPECT_EQ(status.to_string(), said);
    EXPECT_TRUE(model == before);
  };
  using Model = tinygltf::Model;
  const auto second = [](Model& model) -> tinygltf::Value::Object& {
    return model.meshes[1].primitives[0].extensions[kName].Get<tinygltf::Value::Object>();
  };
  const std::string at = "mesh 1, primitive 0: ";
  const StatusCode invalid = StatusCode::kInvalidInput;
  expect_refused([&](Model& model) { second(model)["bufferView"] = tinygltf::Value(99); },
                 at + "the extension has no buffer view", invalid);
  expect_refused([&](Model& model) { second(model)["bufferView"] = tinygltf::Value(std::string("3")); },
                 at + "the extension has no buffer view", invalid);
  expect_refused([&](Model& model) { second(model).erase("attributes"); },
                 at + "the extension has no attributes", invalid);
  expect_refused(
      [&](Model& model) {
        second(model)["attributes"].Get<tinygltf::Value::Object>()["POSITION"] = tinygltf::Value(-1);
      },
      at + "the extension's attribute POSITION has no unique id", invalid);
  expect_refused([&](Model& model) { model.meshes[1].primitives[0].attributes.clear(); },
                 at + "the extension's attribute POSITION has no accessor", invalid);
  expect_refused([&](Model& model) { model.meshes[1].primitives[0].attributes["POSITION"] = -7; },
                 at + "the extension's attribute POSITION has no accessor", invalid);
  expect_refused([&](Model& model) { model.meshes[1].primitives[0].extensions[kName] = tinygltf::Value(1); },
                 at + "the extension is not an object", invalid);
  expect_refused([&](Model& model) { model.meshes[1].primitives[0].mode = TINYGLTF_MODE_LINE; },
                 at + "patches are triangle lists, and the mode is another", invalid);
  expect_refused([&](Model& model) { model.meshes[1].primitives[0].indices = 99; },
                 at + "the indices have no accessor of unsigned integers", invalid);
  const auto view =
      static_cast<size_t>(good.meshes[0].primitives[0].extensions.at(kName).Get("bufferView").GetNumberAsInt());
  const std::string first = "mesh 0, primitive 0";
  expect_refused([&](Model& model) { model.bufferViews[view].byteOffset = ~size_t{0} - 2; },
                 first + ": the extension's buffer view leaves its buffer", invalid);
  expect_refused([&](Model& model) { model.bufferViews[view].byteLength -= 1; },
                 first + ": container: its length is not the sum of its parts", invalid);
  expect_refused(
      [&](Model& model) {
        model.accessors[0].count += 1;
        model.accessors[1].count += 1;
      },
      first + ": the accessors have 1682 points, the directory says 1681", invalid);
}

TEST_F(TinyGltfPlugin, BrokenStreamsNameTheirPatch) {
  Document document = encoded(make_grid(40, 40));
  tinygltf::Model model = parsed(write(document));
  const auto view = static_cast<size_t>(
      model.meshes[0].primitives[0].extensions.at(kName).Get("bufferView").GetNumberAsInt());
  const tinygltf::BufferView& bytes = model.bufferViews[view];
  std::fill_n(model.buffers[0].data.begin() + static_cast<ptrdiff_t>(bytes.byteOffset + bytes.byteLength - 40),
              40, static_cast<unsigned char>(0xff));
  const tinygltf::Model before = model;
  const Status status = decode_model(model);
  EXPECT_EQ(status.code(), StatusCode::kInvalidInput);
  EXPECT_EQ(status.to_string().rfind("mesh 0, primitive 0, patch 4: ", 0), 0u) << status.to_string();
  EXPECT_TRUE(model == before);
}

TEST_F(TinyGltfPlugin, RefusesUnknownRequiredExtensionsWhereAskedTo) {
  Document document = encoded(make_grid(4, 4));
  document.json()["extensionsUsed"].push_back("VENDOR_x");
  document.json()["extensionsRequired"].push_back("VENDOR_x");
  const fs::path path = write(document);
  ModelOptions options;
  tinygltf::Model model = parsed(path);
  EXPECT_TRUE(decode_model(model, options).ok());
  EXPECT_EQ(model.extensionsRequired, std::vector<std::string>{"VENDOR_x"});
  options.known_extensions.emplace();
  model = parsed(path);
  const Status status = decode_model(model, options);
  EXPECT_EQ(status.code(), StatusCode::kUnsupported);
  EXPECT_EQ(status.to_string(), "the extension VENDOR_x is required, and not known");
  options.known_extensions->push_back("VENDOR_x");
  EXPECT_TRUE(decode_model(model, options).ok());
}

TEST_F(TinyGltfPlugin, TellsHowFarItIsAndStops) {
  const fs::path path = write(encoded(make_grid(60, 60)));
  tinygltf::Model model = parsed(path);
  const tinygltf::Model before = model;
  std::atomic<bool> stop = false;
  std::atomic<size_t> calls = 0;
  ModelOptions options;
  const ThreadPool pool(1);
  options.pool = &pool;
  options.stop = &stop;
  options.progress = [&](size_t, size_t total) {
    EXPECT_EQ(total, 5u);
    ++calls;
    stop = true;
  };
  EXPECT_EQ(decode_model(model, options).code(), StatusCode::kCancelled);
  EXPECT_EQ(calls, 1u);
  EXPECT_TRUE(model == before);
  options.stop = nullptr;
  EXPECT_TRUE(decode_model(model, options).ok());
  EXPECT_GT(calls, 2u);
}

TEST_F(TinyGltfPlugin, TakesTheBackendThatItIsGiven) {
  const fs::path path = write(encoded(rich_mesh()));
  tinygltf::Model by_cpu = parsed(path), by_draco = by_cpu;
  const DecodeBackend draco = draco_backend();
  ModelOptions options;
  options.backend = &draco;
  ASSERT_TRUE(decode_model(by_cpu).ok());
  ASSERT_TRUE(decode_model(by_draco, options).ok());
  EXPECT_TRUE(by_cpu == by_draco);
}

// Primitives that share a container, each with accessors of its own.
TEST_F(TinyGltfPlugin, RefusesMorePrimitivesThanTheirContainersJustify) {
  tinygltf::Model model = parsed(write(encoded(make_grid(200, 200))));
  const tinygltf::Primitive primitive = model.meshes.at(0).primitives.at(0);
  for (int copy = 0; copy < 3000; ++copy) {
    model.accessors.push_back(model.accessors.at(static_cast<size_t>(primitive.indices)));
    model.meshes[0].primitives.push_back(primitive);
    model.meshes[0].primitives.back().indices = static_cast<int>(model.accessors.size() - 1);
  }
  const Status status = decode_model(model);
  EXPECT_EQ(status.code(), StatusCode::kInvalidInput);
  EXPECT_TRUE(contains(status.message(), "justify"));
}

// Stock Draco decodes as with libdraco, bit for bit.

constexpr const char* kStock = "KHR_draco_mesh_compression";

Document stock(const Mesh& mesh) {
  Document document = document_from_mesh(mesh);
  const auto reports = must(encode_document_stock(document, {}, test_pool()));
  EXPECT_TRUE(primitive_of(document)["extensions"].contains(kStock));
  return document;
}

TEST_F(TinyGltfPlugin, FillsMemoryOfTheDeviceWhereThereIsOne) {
  std::string why;
  const bool has_device = cuda_available(&why);
  for (const Document& document : {encoded(make_grid(50, 50)), stock(make_grid(50, 50))}) {
    const Expected<Mesh> expected = read(document);
    const tinygltf::Model model = parsed(write(document));
    const Expected<DeviceModel> device = decode_model_to_device(model);
    if (!has_device) {
      EXPECT_EQ(device.status().code(), StatusCode::kUnsupported);
      EXPECT_EQ(device.status().to_string(), "no CUDA device to decode on: " + why);
      continue;
    }
    ASSERT_TRUE(device) << device.status().to_string();
    ASSERT_EQ(device->primitives.size(), 1u);
    const DevicePrimitive& primitive = device->primitives[0];
    EXPECT_EQ(primitive.point_count, expected->point_count);
    std::vector<std::byte> values(expected->attributes[0].values.size());
    ASSERT_TRUE(CudaMemory::download(primitive.attributes[0].values, values).ok());
    EXPECT_TRUE(std::equal(values.begin(), values.end(), expected->attributes[0].values.begin()));
    std::vector<uint16_t> indices(size_t{3} * primitive.face_count);
    ASSERT_EQ(primitive.index_bytes, 2u);
    ASSERT_TRUE(CudaMemory::download(primitive.indices, std::as_writable_bytes(std::span(indices))).ok());
    for (size_t i = 0; i < indices.size(); ++i) ASSERT_EQ(indices[i], expected->faces[i / 3][i % 3]) << i;
  }
  if (!has_device) GTEST_SKIP() << why;
}

TEST_F(TinyGltfPlugin, DecodesStockDraco) {
  for (const Mesh& mesh : {make_grid(20, 20), rich_mesh()}) {
    const Document document = stock(mesh);
    const Mesh expected = must(read(document));
    for (const char* name : {"asset.glb", "asset.gltf"}) {
      tinygltf::Model model = parsed(write(document, name));
      must(decode_model(model));
      expect_plain(model);
      EXPECT_TRUE(same(mesh_of(model), expected));
    }
  }
}

TEST_F(TinyGltfPlugin, DecodesBothExtensionsOfOneModelAtOnce) {
  // Two meshes in one document. One of them is split.
  Document document = stock(rich_mesh());
  const Expected<Mesh> expected = read(document);
  Document other = encoded(make_grid(60, 60));
  const Expected<Mesh> split = read(other);
  ASSERT_TRUE(expected && split);
  tinygltf::Model model = parsed(write(document, "a.glb")), more = parsed(write(other, "b.glb"));
  const int accessors = static_cast<int>(model.accessors.size()),
            views = static_cast<int>(model.bufferViews.size()),
            buffers = static_cast<int>(model.buffers.size());
  for (tinygltf::Accessor accessor : more.accessors) {
    if (accessor.bufferView >= 0) accessor.bufferView += views;
    model.accessors.push_back(std::move(accessor));
  }
  for (tinygltf::BufferView view : more.bufferViews) {
    view.buffer += buffers;
    model.bufferViews.push_back(std::move(view));
  }
  model.buffers.insert(model.buffers.end(), more.buffers.begin(), more.buffers.end());
  tinygltf::Primitive primitive = more.meshes[0].primitives[0];
  primitive.indices += accessors;
  for (auto& [semantic, accessor] : primitive.attributes) accessor += accessors;
  tinygltf::Value::Object& extension = primitive.extensions[kName].Get<tinygltf::Value::Object>();
  extension["bufferView"] = tinygltf::Value(extension["bufferView"].GetNumberAsInt() + views);
  model.meshes[0].primitives.push_back(std::move(primitive));
  for (auto* list : {&model.extensionsUsed, &model.extensionsRequired}) list->push_back(kName);

  std::atomic<size_t> total = 0;
  ModelOptions options;
  const ThreadPool pool(3);
  options.pool = &pool;
  options.known_extensions.emplace();
  options.progress = [&](size_t, size_t of) { total = of; };
  must(decode_model(model, options));
  EXPECT_EQ(total, 6u);  // five patches and a stream, in one batch
  expect_plain(model);
  EXPECT_TRUE(same(mesh_of(model), *expected));
  EXPECT_TRUE(same(mesh_of(model, 0, 1), *split));
}

// A tinygltf with a decoder of its own leaves values in its own buffers, and the extension in its place.
TEST_F(TinyGltfPlugin, DecodesWhatTinyGltfHasDecodedAlready) {
  const Document document = stock(rich_mesh());
  const Expected<Mesh> expected = read(document);
  tinygltf::Model model = parsed(write(document));
  for (tinygltf::Accessor& accessor : model.accessors) {
    model.buffers.emplace_back();
    model.buffers.back().data.assign(accessor.count * 64, 0xab);
    model.bufferViews.emplace_back();
    model.bufferViews.back().buffer = static_cast<int>(model.buffers.size() - 1);
    model.bufferViews.back().byteLength = model.buffers.back().data.size();
    accessor.bufferView = static_cast<int>(model.bufferViews.size() - 1);
  }
  must(decode_model(model));
  expect_plain(model);
  EXPECT_TRUE(same(mesh_of(model), *expected));
}

TEST_F(TinyGltfPlugin, StripsOfStockDracoBecomeLists) {
  Document document = stock(make_grid(9, 9));
  const Expected<Mesh> expected = read(document);
  primitive_of(document)["mode"] = TINYGLTF_MODE_TRIANGLE_STRIP;
  accessor_of(document, "indices")["count"] = 2 + expected->faces.size();
  tinygltf::Model model = parsed(write(document));
  must(decode_model(model));
  EXPECT_EQ(model.meshes[0].primitives[0].mode, TINYGLTF_MODE_TRIANGLES);
  EXPECT_TRUE(same(mesh_of(model), *expected));
  primitive_of(document)["mode"] = TINYGLTF_MODE_POINTS;
  model = parsed(write(document));
  EXPECT_EQ(decode_model(model).to_string(),
            "mesh 0, primitive 0: Draco meshes are triangles, and the mode is another");
}

TEST_F(TinyGltfPlugin, SaysWhatIsWrongWithStockDraco) {
  const tinygltf::Model good = parsed(write(stock(make_grid(9, 9))));
  const auto view = static_cast<size_t>(
      good.meshes[0].primitives[0].extensions.at(kStock).Get("bufferView").GetNumberAsInt());
  const auto refused = [&](auto change) {
    tinygltf::Model model = good;
    change(model);
    const tinygltf::Model before = model;
    const Status status = decode_model(model);
    EXPECT_TRUE(model == before);
    return status.to_string();
  };
  using Model = tinygltf::Model;
  EXPECT_EQ(
      refused([&](Model& model) { model.buffers[0].data[model.bufferViews[view].byteOffset + 6] = 1; }),
      "mesh 0, primitive 0: Draco stream: of bitstream 2.1, which is older than 2.2, the only one that is "
      "decoded; a build with the encoder and libdraco decodes older ones");
  EXPECT_NE(refused([&](Model& model) { model.bufferViews[view].byteLength -= 5; }), "");
  EXPECT_EQ(refused([&](Model& model) {
              model.accessors[static_cast<size_t>(model.meshes[0].primitives[0].indices)].count += 3;
            }),
            "mesh 0, primitive 0: the accessors have 489 indices, the stream has 486");
}

TEST_F(TinyGltfPlugin, LibdracoDecodesOlderBitstreams) {
  tinygltf::Model model = parsed(write(stock(make_grid(9, 9))));
  tinygltf::Primitive& primitive = model.meshes[0].primitives[0];
  const auto view = static_cast<size_t>(primitive.extensions.at(kStock).Get("bufferView").GetNumberAsInt());
  const std::vector<uint8_t> stream = older_stream();
  tinygltf::BufferView& bytes = model.bufferViews[view];
  ASSERT_GE(bytes.byteLength, stream.size());
  bytes.byteLength = stream.size();
  std::copy(stream.begin(), stream.end(),
            model.buffers[0].data.begin() + static_cast<std::ptrdiff_t>(bytes.byteOffset));
  using Object = tinygltf::Value::Object;
  primitive.extensions[kStock] =
      tinygltf::Value(Object{{"bufferView", tinygltf::Value(static_cast<int>(view))},
                             {"attributes", tinygltf::Value(Object{{"POSITION", tinygltf::Value(5)}})}});
  const int position = primitive.attributes.at("POSITION");
  primitive.attributes = {{"POSITION", position}};
  model.accessors[static_cast<size_t>(position)].count = 4;
  model.accessors[static_cast<size_t>(primitive.indices)].count = 6;
  EXPECT_EQ(decode_model(model).code(), StatusCode::kUnsupported);
  ModelOptions options;
  options.older = older_streams();
  must(decode_model(model, options));
  const tinygltf::Accessor& accessor = model.accessors[static_cast<size_t>(position)];
  const tinygltf::BufferView& values = model.bufferViews[static_cast<size_t>(accessor.bufferView)];
  float last = 0;
  std::memcpy(&last, model.buffers[static_cast<size_t>(values.buffer)].data.data() + values.byteOffset + 44,
              sizeof(last));
  EXPECT_EQ(last, 0.5F);
}

// Calls visit(path) with each glTF file of the corpus that has at most `most_bytes`. visit returns the number
// of primitives that it compared.
template <typename Visit>
void for_each_real_asset(uintmax_t least_bytes, uintmax_t most_bytes, size_t least_count, Visit visit) {
  const fs::path corpus = corpus_folder() / "gltf";
  if (!fs::is_directory(corpus)) GTEST_SKIP() << "no corpus at " << corpus;
  size_t assets = 0, primitives = 0;
  for (const auto& entry : fs::recursive_directory_iterator(corpus)) {
    const fs::path& path = entry.path();
    if (path.extension() != ".glb" && path.extension() != ".gltf") continue;
    if (entry.file_size() < least_bytes || entry.file_size() > most_bytes) continue;
    SCOPED_TRACE(path.string());
    const size_t compared = visit(path);
    primitives += compared;
    assets += compared > 0;
  }
  std::cout << assets << " assets, " << primitives << " primitives\n";
  EXPECT_GE(assets, least_count);
}

TEST_F(TinyGltfPlugin, DecodesTheStockDracoOfRealAssets) {
  for_each_real_asset(0, UINTMAX_MAX, 7, [](const fs::path& path) {
    const Expected<Document> document = read_document(path);
    if (!document || count_in(*document, kStock) == 0) return size_t{0};
    const std::vector<PrimitiveId> ids = all_primitives(*document);
    const std::vector<Expected<Mesh>> expected = read_primitives(*document, ids, draco_backend(), test_pool());
    tinygltf::Model model = parsed(path);
    must(decode_model(model));
    expect_plain(model);
    for (size_t i = 0; i < ids.size(); ++i)
      EXPECT_TRUE(same(mesh_of(model, ids[i].mesh, ids[i].primitive), must(expected[i])))
          << "mesh " << ids[i].mesh << ", primitive " << ids[i].primitive;
    return ids.size();
  });
}

// Assets of other authors whose files have this many bytes. With the plugin they have the same values as their
// plain files.
struct Sizes {
  uintmax_t least, most;
  size_t least_count;
};
class RealAssets : public TinyGltfPlugin, public testing::WithParamInterface<Sizes> {};

INSTANTIATE_TEST_SUITE_P(Small, RealAssets, testing::Values(Sizes{0, 300'000, 10}));
INSTANTIATE_TEST_SUITE_P(LargeTakesLong, RealAssets, testing::Values(Sizes{300'001, 3'000'000, 10}));

TEST_P(RealAssets, LoadAsTheirPlainFiles) {
  const auto& [least, most, least_count] = GetParam();
  for_each_real_asset(least, most, least_count, [&](const fs::path& path) {
    size_t primitives = 0;
    Expected<Document> document = read_document(path);
    if (!document) return primitives;
    const EncodeDocumentOptions options =
        DocumentOptions{.patches = {.faces = 600, .always = true}, .verify = false};
    if (!encode_document(*document, options, draco_backend(), test_pool())) return primitives;
    // tinygltf cannot read views that meshoptimizer compressed, and these stay compressed.
    if (document->json().dump().find("meshopt_compression") != std::string::npos) return primitives;
    const fs::path patched = write(*document, "patched.glb");
    must(decode(*document));
    const fs::path plain = write(*document, "plain.glb");
    tinygltf::Model expected;
    std::string error;
    if (!parse(plain, expected, error, false)) return primitives;  // tinygltf has limits of its own
    tinygltf::Model model = parsed(patched);
    must(decode_model(model));
    expect_plain(model);
    EXPECT_EQ(model.meshes.size(), expected.meshes.size());
    for (size_t m = 0; m < model.meshes.size(); ++m)
      for (size_t p = 0; p < model.meshes[m].primitives.size(); ++p, ++primitives)
        EXPECT_TRUE(same(mesh_of(model, m, p), mesh_of(expected, m, p))) << "mesh " << m << ", primitive " << p;
    return primitives;
  });
}

}  // namespace
}  // namespace psplit
