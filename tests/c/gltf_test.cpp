// glTF files through the C interface.
#include <algorithm>
#include <cstring>

#include "gltf_ext/json/glb.h"
#include "psplit/encode.h"
#include "tests/c/handles.h"
#include "tests/support/default_codings.h"
#include "tests/support/expect.h"
#include "tests/support/mutants.h"
#include "tests/support/patched_samples.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/same_bits.h"
#include "tests/support/sanitizers.h"
#include "tests/support/stock_stream.h"

namespace psplit {
namespace {

// A mesh stored as both extensions store it.
struct GltfSample {
  PatchedSample patches;
  StockStream stock;
};
const GltfSample& gltf_sample() {
  static const GltfSample made = [] {
    const auto has_texcoords = [](const NamedMesh& named) { return named.mesh.find("TEXCOORD_0") != nullptr; };
    const Mesh& mesh = std::ranges::find_if(procedural_meshes(), has_texcoords)->mesh;
    const std::vector<AttributeCoding> codings = default_codings(mesh, false).codings;
    return GltfSample{encode_sample("sample", mesh, codings, {.patch_count = 4}, ThreadPool(2)),
                      must(encode_stock_stream(mesh, codings, 5))};
  }();
  return made;
}

std::string type_of(const AttributeRequest& request) {
  return request.component_count == 1 ? "SCALAR" : "VEC" + std::to_string(request.component_count);
}

// The JSON of a file with mesh 0: a plain primitive and one of patches; mesh 1: one of stock Draco. View 0 is
// the container, view 1 the stream. Both are in buffer 0, or the stream in buffer 1.
struct File {
  std::string json{};
  std::vector<uint8_t> first{}, second{};

  explicit File(const std::string& uris = "") {
    const std::vector<uint8_t>&container = gltf_sample().patches.encoded.pieces[0].bytes,
          &stream = gltf_sample().stock.bytes;
    first = container;
    first.resize((first.size() + 3) / 4 * 4);
    size_t stream_at = 0;
    if (uris.empty()) {
      stream_at = first.size();
      first.insert(first.end(), stream.begin(), stream.end());
      first.resize((first.size() + 3) / 4 * 4);
    } else {
      second = stream;
    }
    const int buffer = uris.empty() ? 0 : 1;
    std::string accessors, primitives[2];
    int count = 0;
    const auto add = [&](const Mesh& mesh, std::span<const AttributeRequest> requests, const char* extension,
                         int view) {
      std::string attributes, ids;
      for (const AttributeRequest& request : requests) {
        accessors += std::string(count == 0 ? "" : ",") + R"({"componentType":)" +
                     std::to_string(static_cast<int>(request.component_type)) + R"(,"type":")" +
                     type_of(request) + R"(","normalized":)" + (request.normalized ? "true" : "false") +
                     R"(,"count":)" + std::to_string(mesh.point_count) + "}";
        const std::string separator = attributes.empty() ? "\"" : ",\"";
        attributes += separator + request.semantic + "\":" + std::to_string(count++);
        ids += separator + request.semantic + "\":" + std::to_string(request.unique_id);
      }
      accessors +=
          R"(,{"componentType":5125,"type":"SCALAR","count":)" + std::to_string(3 * mesh.faces.size()) + "}";
      primitives[view] = R"({"attributes":{)" + attributes + R"(},"indices":)" + std::to_string(count++) +
                         R"(,"extensions":{")" + extension + R"(":{"bufferView":)" + std::to_string(view) +
                         R"(,"attributes":{)" + ids + "}}}}";
    };
    add(gltf_sample().patches.mesh, gltf_sample().patches.requests, "PSPLIT_mesh_draco_patches", 0);
    add(gltf_sample().stock.decoded, gltf_sample().stock.requests, "KHR_draco_mesh_compression", 1);
    json = R"({"asset":{"version":"2.0"},"accessors":[)" + accessors + R"(],"buffers":[)" +
           (uris.empty()
                ? R"({"byteLength":)" + std::to_string(first.size()) + "}"
                : R"({"byteLength":)" + std::to_string(first.size()) + R"(,"uri":"a.bin"},{"byteLength":)" +
                      std::to_string(second.size()) + R"(,"uri":")" + uris + R"("})") +
           R"(],"bufferViews":[{"buffer":0,"byteLength":)" + std::to_string(container.size()) +
           R"(},{"buffer":)" + std::to_string(buffer) + R"(,"byteOffset":)" + std::to_string(stream_at) +
           R"(,"byteLength":)" + std::to_string(stream.size()) +
           R"(}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}},)" + primitives[0] +
           R"(]},{"primitives":[)" + primitives[1] + "]}]}";
  }

  std::vector<uint8_t> glb() const {
    std::vector<uint8_t> file = must(glb_head(json, first.size()));
    file.insert(file.end(), first.begin(), first.end());
    return file;
  }
  std::vector<uint8_t> gltf() const { return {json.begin(), json.end()}; }
};

struct OpenedGltf {
  psplit_code code = PSPLIT_OK;
  psplit_error error = init<psplit_error>();
  Handle<psplit_gltf> gltf{};
};
OpenedGltf open_gltf(std::span<const uint8_t> file, uint32_t flags = 0) {
  auto source = init<psplit_gltf_source>();
  source.data = file.data();
  source.size = file.size();
  source.flags = flags;
  OpenedGltf opened;
  psplit_gltf* gltf = nullptr;
  opened.code = psplit_gltf_open(&source, &gltf, &opened.error);
  opened.gltf.reset(gltf);
  EXPECT_EQ(opened.code == PSPLIT_OK, gltf != nullptr);
  return opened;
}
Opened open_primitive(const psplit_gltf* gltf, uint32_t mesh, uint32_t primitive) {
  Opened opened;
  psplit_mesh* made = nullptr;
  opened.code = psplit_gltf_open_primitive(gltf, mesh, primitive, &made, &opened.error);
  opened.mesh.reset(made);
  return opened;
}

void expect_mesh(const Opened& opened, std::span<const AttributeRequest> requests, const Mesh& expected) {
  ASSERT_EQ(opened.code, PSPLIT_OK) << opened.error.text;
  const psplit_mesh_info info = info_of(opened.mesh.get());
  ASSERT_EQ(info.point_count, expected.point_count);
  ASSERT_EQ(info.attribute_count, requests.size());
  for (uint32_t k = 0; k < requests.size(); ++k)
    EXPECT_EQ(attribute_of(opened.mesh.get(), k).name, requests[k].semantic);
  Buffers buffers(requests, info.point_count, info.face_count);
  const CBuffers out(buffers.out);
  ASSERT_EQ(psplit_mesh_decode(opened.mesh.get(), &out.buffers, nullptr, nullptr), PSPLIT_OK);
  EXPECT_TRUE(same_bits(buffers.mesh(requests, info.point_count), expected));
}

TEST(CGltf, PrimitivesOfBothExtensionsAreOpened) {
  std::vector<uint8_t> bytes = File().glb();
  OpenedGltf opened = open_gltf(bytes, PSPLIT_COPY);
  ASSERT_EQ(opened.code, PSPLIT_OK) << opened.error.text;
  bytes.assign(bytes.size(), 0);
  const psplit_gltf* const gltf = opened.gltf.get();
  EXPECT_EQ(psplit_gltf_mesh_count(gltf), 2u);
  EXPECT_EQ(psplit_gltf_primitive_count(gltf, 0), 2u);
  EXPECT_EQ(psplit_gltf_primitive_count(gltf, 1), 1u);
  EXPECT_EQ(psplit_gltf_primitive_count(gltf, 2), 0u);
  EXPECT_EQ(psplit_gltf_primitive_kind(gltf, 0, 0), PSPLIT_KIND_NONE);
  EXPECT_EQ(psplit_gltf_primitive_kind(gltf, 0, 1), PSPLIT_KIND_PATCHES);
  EXPECT_EQ(psplit_gltf_primitive_kind(gltf, 1, 0), PSPLIT_KIND_DRACO);
  EXPECT_EQ(psplit_gltf_primitive_kind(gltf, 9, 9), PSPLIT_KIND_NONE);
  const Opened plain = open_primitive(gltf, 0, 0), none = open_primitive(gltf, 0, 2);
  EXPECT_EQ(plain.code, PSPLIT_ERROR_USAGE);
  EXPECT_STREQ(plain.error.text, "mesh 0, primitive 0: it has neither of the two extensions");
  EXPECT_EQ(none.code, PSPLIT_ERROR_USAGE);
  EXPECT_EQ(none.error.mesh, 0);
  EXPECT_EQ(none.error.primitive, 2);
  const Opened patches = open_primitive(gltf, 0, 1), stock = open_primitive(gltf, 1, 0);
  opened.gltf.reset();  // meshes keep what they need
  expect_mesh(patches, gltf_sample().patches.requests, gltf_sample().patches.mesh);
  expect_mesh(stock, gltf_sample().stock.requests, gltf_sample().stock.decoded);
  // Errors of decoding name the primitive.
  auto error = init<psplit_error>();
  auto buffers = init<psplit_buffers>();
  EXPECT_EQ(psplit_mesh_decode(stock.mesh.get(), &buffers, nullptr, &error), PSPLIT_ERROR_USAGE);
  EXPECT_EQ(error.mesh, 1);
  EXPECT_EQ(std::string(error.text).substr(0, 21), "mesh 1, primitive 0: ");
}

TEST(CGltf, CoarsePrimitivesAreReplaced) {
  File file;
  const std::string fine = file.json.substr(file.json.rfind(R"(,{"primitives":)") + 1);
  ASSERT_TRUE(fine.ends_with("]}]}"));
  const auto with = [&](const std::string& extension) {
    File changed = file;
    const size_t at = changed.json.size() - fine.size();
    changed.json.replace(at, fine.size(),
                         R"({"primitives":[{"attributes":{"POSITION":0}},{"attributes":{"POSITION":0}}],)"
                         R"("extensions":{"PSPLIT_mesh_draco_patches":)" +
                             extension + "}}]}");
    return open_gltf(changed.glb(), PSPLIT_COPY);
  };
  const OpenedGltf opened = with(fine.substr(0, fine.size() - 2));
  ASSERT_EQ(opened.code, PSPLIT_OK) << opened.error.text;
  EXPECT_EQ(psplit_gltf_primitive_count(opened.gltf.get(), 1), 1u);
  expect_mesh(open_primitive(opened.gltf.get(), 1, 0), gltf_sample().stock.requests,
              gltf_sample().stock.decoded);
  for (const char* broken : {"null", "{}", R"({"primitives":[]})", R"({"primitives":[0]})"})
    EXPECT_EQ(with(broken).code, PSPLIT_ERROR_INVALID_INPUT) << broken;
}

TEST(CGltf, TheCallerGivesTheBytesOfUris) {
  const File file("b%20c.bin");
  const OpenedGltf opened = open_gltf(file.gltf());
  ASSERT_EQ(opened.code, PSPLIT_OK) << opened.error.text;
  psplit_gltf* const gltf = opened.gltf.get();
  ASSERT_EQ(psplit_gltf_buffer_count(gltf), 2u);
  EXPECT_STREQ(psplit_gltf_buffer_uri(gltf, 0), "a.bin");
  EXPECT_STREQ(psplit_gltf_buffer_uri(gltf, 1), "b%20c.bin");
  EXPECT_EQ(psplit_gltf_buffer_uri(gltf, 2), nullptr);
  const Opened early = open_primitive(gltf, 1, 0);
  EXPECT_EQ(early.code, PSPLIT_ERROR_USAGE);
  EXPECT_STREQ(early.error.text, "mesh 1, primitive 0: the bytes of buffer 1 are not set");
  auto error = init<psplit_error>();
  EXPECT_EQ(psplit_gltf_set_buffer(gltf, 2, file.second.data(), file.second.size(), &error),
            PSPLIT_ERROR_USAGE);
  EXPECT_EQ(psplit_gltf_set_buffer(gltf, 1, nullptr, 1, &error), PSPLIT_ERROR_USAGE);
  EXPECT_EQ(psplit_gltf_set_buffer(gltf, 1, file.second.data(), file.second.size() - 1, &error),
            PSPLIT_ERROR_INVALID_INPUT);
  EXPECT_EQ(psplit_gltf_set_buffer(gltf, 1, file.second.data(), file.second.size(), &error), PSPLIT_OK);
  expect_mesh(open_primitive(gltf, 1, 0), gltf_sample().stock.requests, gltf_sample().stock.decoded);
  EXPECT_EQ(open_primitive(gltf, 0, 1).code, PSPLIT_ERROR_USAGE);
  EXPECT_EQ(psplit_gltf_set_buffer(gltf, 0, file.first.data(), file.first.size(), &error), PSPLIT_OK);
  expect_mesh(open_primitive(gltf, 0, 1), gltf_sample().patches.requests, gltf_sample().patches.mesh);
}

TEST(CGltf, ContradictionsAreErrorsOfThePrimitive) {
  const auto error_of = [](const std::string& part, const std::string& by, uint32_t mesh, uint32_t primitive) {
    File file;
    const size_t at = file.json.find(part);
    EXPECT_NE(at, std::string::npos) << part;
    file.json.replace(at, part.size(), by);
    const std::vector<uint8_t> bytes = file.glb();
    const OpenedGltf opened = open_gltf(bytes);
    if (opened.code != PSPLIT_OK) return std::string("the file: ") + opened.error.text;
    return std::string(open_primitive(opened.gltf.get(), mesh, primitive).error.text);
  };
  const std::string count = "\"count\":" + std::to_string(gltf_sample().patches.mesh.point_count);
  EXPECT_TRUE(contains(error_of(count, "\"count\":0", 0, 1), "the accessor of POSITION is empty"));
  EXPECT_TRUE(contains(error_of(count, "\"count\":7", 0, 1), "has another count than others"));
  EXPECT_TRUE(
      contains(error_of("\"indices\":", "\"mode\":5,\"indices\":", 0, 1), "its mode is not that of triangles"));
  EXPECT_TRUE(contains(error_of("{\"bufferView\":0", "{\"view\":0", 0, 1), "bufferView"));
  EXPECT_TRUE(contains(error_of("\"buffer\":0,\"byteLength\":", "\"buffer\":0,\"byteLength\":9", 0, 1),
                       "the file: buffer view 0 reaches past its buffer"));
  EXPECT_TRUE(contains(error_of("\"2.0\"", "\"1.0\"", 0, 1), "the file: glTF version \"1.0\""));
}

TEST(CGltf, MutantsAreErrors) {
  const std::vector<uint8_t> right = File().glb();
  const size_t json_end = right.size() - File().first.size();
  std::mt19937 random(5);
  const auto try_file = [](const std::vector<uint8_t>& bytes) {
    const OpenedGltf opened = open_gltf(bytes);
    if (opened.code != PSPLIT_OK) {
      EXPECT_TRUE(opened.code == PSPLIT_ERROR_INVALID_INPUT || opened.code == PSPLIT_ERROR_UNSUPPORTED);
      return;
    }
    for (uint32_t mesh = 0; mesh < psplit_gltf_mesh_count(opened.gltf.get()); ++mesh)
      for (uint32_t n = 0; n < psplit_gltf_primitive_count(opened.gltf.get(), mesh); ++n)
        (void)open_primitive(opened.gltf.get(), mesh, n);
  };
  for (size_t i = 0; i < fewer_with_sanitizers(2000); ++i) {
    std::vector<uint8_t> bytes = right;
    edit(bytes, random() % json_end, random);
    try_file(bytes);
  }
  for (size_t length = 0; length < json_end + 8; length += 3)
    try_file(std::vector<uint8_t>(right.begin(), right.begin() + static_cast<std::ptrdiff_t>(length)));
}

TEST(CGltf, SourcesHaveTheirSize) {
  auto source = init<psplit_gltf_source>();
  psplit_gltf* gltf = nullptr;
  EXPECT_EQ(psplit_gltf_open(&source, &gltf, nullptr), PSPLIT_ERROR_INVALID_INPUT);
  source.struct_size = 8;
  EXPECT_EQ(psplit_gltf_open(&source, &gltf, nullptr), PSPLIT_ERROR_USAGE);
  source.struct_size = sizeof(source);
  source.flags = PSPLIT_INTEGERS;
  EXPECT_EQ(psplit_gltf_open(&source, &gltf, nullptr), PSPLIT_ERROR_USAGE);
}

}  // namespace
}  // namespace psplit
