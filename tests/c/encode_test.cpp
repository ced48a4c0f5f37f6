// Encoding through the C interface gives the bytes of the C++ interface.
#include "psplit/encode.h"

#include <algorithm>
#include <cstring>

#include "encoder/coding/choose_codings.h"
#include "encoder/encode_mesh.h"
#include "src/container/stored_type.h"
#include "tests/c/handles.h"
#include "tests/support/expect.h"
#include "tests/support/patched_samples.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/stock_stream.h"

namespace psplit {
namespace {

// A mesh in the caller's memory: indices of `index_size` bytes, and values with a gap after each.
struct CSource {
  Mesh mesh;  // has the names
  std::vector<uint8_t> indices{};
  std::vector<std::vector<std::byte>> values{};
  std::vector<psplit_attribute_values> attributes{};
  psplit_encode_source source = init<psplit_encode_source>();

  explicit CSource(Mesh of, uint32_t index_size = 4, size_t gap = 0) : mesh(std::move(of)) {
    for (const auto& face : mesh.faces)
      for (const uint32_t point : face) {
        const auto* const bytes = reinterpret_cast<const uint8_t*>(&point);
        indices.insert(indices.end(), bytes, bytes + index_size);
      }
    for (const Attribute& attribute : mesh.attributes) {
      const size_t size = attribute.stride(), stride = size + gap;
      std::vector<std::byte>& bytes = values.emplace_back(mesh.point_count * stride, std::byte{0x77});
      for (size_t point = 0; point < mesh.point_count; ++point)
        std::copy_n(attribute.values.begin() + static_cast<std::ptrdiff_t>(point * size), size,
                    bytes.begin() + static_cast<std::ptrdiff_t>(point * stride));
      attributes.push_back(init<psplit_attribute_values>());
      psplit_attribute_values& element = attributes.back();
      element.name = attribute.semantic.c_str();
      element.type = static_cast<psplit_type>(stored_type(attribute.component_type));
      element.components = attribute.component_count;
      element.normalized = attribute.normalized;
      element.data = bytes.data();
      element.size = bytes.size() - (mesh.point_count > 0 ? gap : 0);
      element.stride = gap == 0 ? 0 : stride;
    }
    source.point_count = mesh.point_count;
    source.indices = indices.data();
    source.indices_size = indices.size();
    source.index_size = index_size;
    source.attributes = attributes.data();
    source.attribute_count = static_cast<uint32_t>(attributes.size());
  }
  CSource(const CSource&) = delete;
};

psplit_encode_options default_options() {
  auto options = init<psplit_encode_options>();
  psplit_encode_options_init(&options);
  return options;
}

struct Result {
  psplit_code code = PSPLIT_OK;
  psplit_error error = init<psplit_error>();
  Handle<psplit_encoded> encoded{};
  psplit_encoded_info info = init<psplit_encoded_info>();

  std::vector<uint8_t> bytes() const {
    const auto* const data = static_cast<const uint8_t*>(info.data);
    return {data, data + info.size};
  }
  std::vector<uint32_t> source_points() const {
    return {info.source_points, info.source_points + info.point_count};
  }
};
Result encode(const psplit_encode_source& source, const psplit_encode_options* options) {
  Result result;
  psplit_encoded* encoded = reinterpret_cast<psplit_encoded*>(1);
  result.code = psplit_encode(&source, options, &encoded, &result.error);
  result.encoded.reset(encoded);
  EXPECT_EQ(result.code == PSPLIT_OK, encoded != nullptr);
  if (encoded != nullptr) {
    EXPECT_EQ(psplit_encoded_get_info(encoded, &result.info, nullptr), PSPLIT_OK);
  }
  return result;
}

void expect_requests(const Result& result, std::span<const AttributeRequest> expected) {
  ASSERT_EQ(result.info.attribute_count, expected.size());
  for (uint32_t k = 0; k < expected.size(); ++k) {
    auto request = init<psplit_attribute_request>();
    EXPECT_EQ(psplit_encoded_get_attribute(result.encoded.get(), k, &request, nullptr), PSPLIT_OK);
    EXPECT_EQ(request.name, expected[k].semantic);
    EXPECT_EQ(request.unique_id, expected[k].unique_id);
    EXPECT_EQ(request.type, static_cast<psplit_type>(stored_type(expected[k].component_type)));
    EXPECT_EQ(request.components, expected[k].component_count);
    EXPECT_EQ(request.normalized != 0, expected[k].normalized);
  }
}

TEST(CEncode, ContainersAreThoseOfTheEncoder) {
  size_t encoded = 0;
  const ThreadPool pool(2);
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    EncodeOptions expected_options;
    expected_options.patches.always = true;
    expected_options.patches.count = 3;
    const Expected<EncodedMesh> expected = encode(mesh, expected_options, pool);
    if (!expected) {
      const CSource source(mesh);
      EXPECT_NE(encode(source.source, nullptr).code, PSPLIT_OK);
      continue;
    }
    psplit_encode_options options = default_options();
    options.kind = PSPLIT_KIND_PATCHES;
    options.patch_count = 3;
    options.threads = 1 + static_cast<int32_t>(encoded % 3);
    const CSource source(mesh,
                         mesh.point_count <= 256     ? 1
                         : mesh.point_count <= 65536 ? 2
                                                     : 4,
                         encoded % 2 * 3);
    const Result result = encode(source.source, &options);
    ASSERT_EQ(result.code, PSPLIT_OK) << result.error.text;
    EXPECT_EQ(result.info.kind, PSPLIT_KIND_PATCHES);
    EXPECT_EQ(result.bytes(), expected->pieces[0].bytes);
    EXPECT_EQ(result.source_points(), expected->pieces[0].source_point);
    EXPECT_EQ(result.info.face_count, expected->pieces[0].decoded.faces.size());
    EXPECT_EQ(result.info.patch_count, expected->pieces[0].entries.size());
    EXPECT_EQ(result.info.position_error, expected->statistics.position_error.value_or(-1));
    expect_requests(result, expected->requests);
    ++encoded;
  }
  EXPECT_GT(encoded, 20u);
}

TEST(CEncode, StockStreamsAreThoseOfTheEncoder) {
  size_t encoded = 0;
  psplit_encode_options options = default_options();
  options.kind = PSPLIT_KIND_DRACO;
  options.speed = 3;
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    EncodeOptions expected_options;
    expected_options.storage = Storage::kOneStream;
    expected_options.keep_duplicates = true;
    expected_options.encode_speed = options.speed;
    const Expected<EncodedMesh> expected = encode(mesh, expected_options, ThreadPool(1));
    const CSource source(mesh);
    const Result result = encode(source.source, &options);
    ASSERT_EQ(result.code == PSPLIT_OK, expected.ok());
    if (!expected) continue;
    EXPECT_EQ(result.info.kind, PSPLIT_KIND_DRACO);
    EXPECT_EQ(result.bytes(), expected->pieces[0].bytes);
    EXPECT_EQ(result.source_points(), expected->pieces[0].source_point);
    EXPECT_EQ(result.info.face_count, expected->pieces[0].decoded.faces.size());
    EXPECT_EQ(result.info.patch_count, 1u);
    EXPECT_EQ(result.info.position_error, expected->statistics.position_error.value_or(-1));
    expect_requests(result, expected->requests);
    ++encoded;
  }
  EXPECT_GT(encoded, 20u);
}

TEST(CEncode, BitsAreThoseOfTheOptionsOrOfTheAttribute) {
  const auto has_all = [](const NamedMesh& named) {
    return named.mesh.find("NORMAL") != nullptr && named.mesh.find("TEXCOORD_0") != nullptr;
  };
  Mesh mesh = std::ranges::find_if(procedural_meshes(), has_all)->mesh;
  for (const char* const name : {"_GENERIC", "_OWN"}) {
    mesh.attributes.push_back(*mesh.find("POSITION"));
    mesh.attributes.back().semantic = name;
  }
  CSource source(mesh);
  psplit_encode_options options = default_options();
  options.position_bits = 11;
  options.normal_bits = 7;
  options.texcoord_bits = -1;
  options.generic_bits = 9;
  options.speed = 2;
  options.flags = PSPLIT_ENCODE_KEEP_DUPLICATES | PSPLIT_ENCODE_WITHOUT_VERIFYING;
  const int own = 13;
  source.attributes.back().bits = own;
  const Result result = encode(source.source, &options);
  ASSERT_EQ(result.code, PSPLIT_OK) << result.error.text;
  EXPECT_LT(result.info.position_error, 0);
  std::vector<psplit_attribute_request> requests;
  for (uint32_t k = 0; k < result.info.attribute_count; ++k) {
    requests.push_back(init<psplit_attribute_request>());
    ASSERT_EQ(psplit_encoded_get_attribute(result.encoded.get(), k, &requests.back(), nullptr), PSPLIT_OK);
  }
  auto stored = init<psplit_source>();
  stored.kind = result.info.kind;
  stored.data = result.info.data;
  stored.size = result.info.size;
  stored.attributes = requests.data();
  stored.attribute_count = result.info.attribute_count;
  psplit_mesh* opened = nullptr;
  ASSERT_EQ(psplit_mesh_open(&stored, &opened, nullptr), PSPLIT_OK);
  const Handle<psplit_mesh> handle(opened);
  const auto bits_of = [&](uint32_t k) {
    auto quantization = init<psplit_quantization>();
    EXPECT_EQ(psplit_mesh_get_quantization(opened, k, &quantization, nullptr), PSPLIT_OK);
    return quantization.bits;
  };
  for (uint32_t k = 0; k < result.info.attribute_count; ++k) {
    const std::string name = mesh.attributes[k].semantic;
    const int expected = k + 1 == result.info.attribute_count ? own
                         : name == "POSITION"                 ? 11
                         : name == "NORMAL"                   ? 7
                         : name.starts_with("TEXCOORD_")      ? 0
                                                              : 9;
    EXPECT_EQ(bits_of(k), expected) << name;
  }
}

TEST(CEncode, WeightsHaveTheSameBits) {
  Mesh mesh = make_grid(3, 3);
  for (const char* const name : {"WEIGHTS_0", "WEIGHTS_1"})
    mesh.attributes.push_back(
        float_attribute(name, 4, std::vector<float>(size_t{4} * mesh.point_count, 0.125f)));
  CSource source(mesh);
  source.attributes[1].bits = source.attributes[2].bits = 10;
  EXPECT_EQ(encode(source.source, nullptr).code, PSPLIT_OK);
  source.attributes[2].bits = 11;
  const Result result = encode(source.source, nullptr);
  EXPECT_EQ(result.code, PSPLIT_ERROR_USAGE);
  EXPECT_STREQ(result.error.text, "WEIGHTS_n have different bits");
}

TEST(CEncode, FacesOfAPatchGiveTheNumberOfPatches) {
  const CSource source(make_grid(40, 40));  // 3,200 faces
  psplit_encode_options options = default_options();
  const auto patches = [&] {
    const Result result = encode(source.source, &options);
    EXPECT_EQ(result.code, PSPLIT_OK) << result.error.text;
    return result.info.patch_count;
  };
  EXPECT_EQ(patches(), 1u);
  options.patch_faces = 400;
  EXPECT_EQ(patches(), 8u);
  options.patch_faces = 1280;
  EXPECT_EQ(patches(), 3u);  // 2.5, rounded up
  options.patch_count = 5;
  EXPECT_EQ(patches(), 5u);
  options.patch_faces = 0;
  options.patch_count = 0;
  EXPECT_EQ(patches(), 1u);
}

TEST(CEncode, ProgressCountsFaces) {
  const Mesh mesh = make_grid(30, 30);
  const CSource source(mesh);
  psplit_encode_options options = default_options();
  options.patch_count = 6;
  options.threads = 1;
  std::vector<std::pair<size_t, size_t>> seen;
  options.user = &seen;
  options.progress = [](void* user, size_t done, size_t total) {
    static_cast<std::vector<std::pair<size_t, size_t>>*>(user)->emplace_back(done, total);
  };
  ASSERT_EQ(encode(source.source, &options).code, PSPLIT_OK);
  ASSERT_EQ(seen.size(), 6u);
  for (size_t i = 0; i < seen.size(); ++i) {
    EXPECT_EQ(seen[i].second, mesh.faces.size());
    EXPECT_GT(seen[i].first, i == 0 ? 0 : seen[i - 1].first);
  }
  EXPECT_EQ(seen.back().first, mesh.faces.size());
}

TEST(CEncode, StopEndsTheWork) {
  const CSource source(make_grid(60, 60));
  psplit_stop* stop = nullptr;
  ASSERT_EQ(psplit_stop_create(&stop, nullptr), PSPLIT_OK);
  for (const psplit_kind kind : {PSPLIT_KIND_PATCHES, PSPLIT_KIND_DRACO})
    for (const bool is_set_before : {true, false}) {
      if (kind == PSPLIT_KIND_DRACO && !is_set_before) continue;  // it has one patch
      SCOPED_TRACE(kind);
      psplit_stop_set(stop, is_set_before ? 1 : 0);
      psplit_encode_options options = default_options();
      options.kind = kind;
      options.patch_count = kind == PSPLIT_KIND_PATCHES ? 12 : 0;
      options.threads = 1;
      options.stop = stop;
      options.user = stop;
      options.progress = [](void* user, size_t, size_t) {
        psplit_stop_set(static_cast<psplit_stop*>(user), 1);
      };
      EXPECT_EQ(encode(source.source, &options).code, PSPLIT_ERROR_CANCELLED);
      psplit_stop_set(stop, 0);
      options.progress = nullptr;
      EXPECT_EQ(encode(source.source, &options).code, PSPLIT_OK);
    }
  psplit_stop_free(stop);
}

TEST(CEncode, NotesSayWhatTheBitsLose) {
  const CSource source(make_grid(60, 60));
  psplit_encode_options options = default_options();
  options.position_bits = 3;
  const Result result = encode(source.source, &options);
  ASSERT_EQ(result.code, PSPLIT_OK);
  ASSERT_GT(result.info.note_count, 0u);
  EXPECT_NE(std::string(psplit_encoded_note(result.encoded.get(), 0)).find("POSITION"), std::string::npos);
  EXPECT_EQ(psplit_encoded_note(result.encoded.get(), result.info.note_count), nullptr);
  EXPECT_EQ(psplit_encoded_note(nullptr, 0), nullptr);
}

TEST(CEncode, WrongSourcesAreErrors) {
  const Mesh mesh = make_grid(4, 4);
  const auto expect = [&](psplit_code code, const char* text, auto change) {
    SCOPED_TRACE(text);
    for (const psplit_kind kind : {PSPLIT_KIND_PATCHES, PSPLIT_KIND_DRACO}) {
      CSource source(mesh);
      psplit_encode_options options = default_options();
      options.kind = kind;
      change(source, options);
      const Result result = encode(source.source, &options);
      EXPECT_EQ(result.code, code);
      EXPECT_NE(std::string(result.error.text).find(text), std::string::npos) << result.error.text;
    }
  };
  using Source = CSource&;
  using Options = psplit_encode_options&;
  expect(PSPLIT_OK, "", [](Source, Options) {});
  expect(PSPLIT_ERROR_USAGE, "indices of 3 bytes", [](Source s, Options) { s.source.index_size = 3; });
  expect(PSPLIT_ERROR_USAGE, "not whole faces", [](Source s, Options) { s.source.indices_size -= 4; });
  expect(PSPLIT_ERROR_USAGE, "indices are null", [](Source s, Options) { s.source.indices = nullptr; });
  expect(PSPLIT_ERROR_INVALID_INPUT, "an index is 4294967295",
         [](Source s, Options) { std::fill_n(s.indices.begin(), 4, uint8_t{0xff}); });
  expect(PSPLIT_ERROR_INVALID_INPUT, "no triangles", [](Source s, Options) { s.source.indices_size = 0; });
  expect(PSPLIT_ERROR_INVALID_INPUT, "no POSITION", [](Source s, Options) { s.source.attribute_count = 0; });
  expect(PSPLIT_ERROR_USAGE, "psplit_attribute_values is null",
         [](Source s, Options) { s.source.attributes = nullptr; });
  expect(PSPLIT_ERROR_USAGE, "POSITION has no values for 25 points",
         [](Source s, Options) { --s.attributes[0].size; });
  expect(PSPLIT_ERROR_USAGE, "POSITION has no values for 25 points",
         [](Source s, Options) { s.attributes[0].data = nullptr; });
  expect(PSPLIT_ERROR_USAGE, "POSITION has no values for 26 points",
         [](Source s, Options) { ++s.source.point_count; });
  expect(PSPLIT_ERROR_USAGE, "the stride of POSITION", [](Source s, Options) { s.attributes[0].stride = 11; });
  expect(PSPLIT_ERROR_USAGE, "no name", [](Source s, Options) { s.attributes[0].name = ""; });
  expect(PSPLIT_ERROR_USAGE, "no name", [](Source s, Options) { s.attributes[0].name = nullptr; });
  expect(PSPLIT_ERROR_UNSUPPORTED, "POSITION has the type 10",
         [](Source s, Options) { s.attributes[0].type = PSPLIT_FLOAT64; });
  expect(PSPLIT_ERROR_UNSUPPORTED, "POSITION has 17 components",
         [](Source s, Options) { s.attributes[0].components = 17; });
  expect(PSPLIT_ERROR_UNSUPPORTED, "POSITION has 0 components",
         [](Source s, Options) { s.attributes[0].components = 0; });
  expect(PSPLIT_ERROR_UNSUPPORTED, "32-bit integers",
         [](Source s, Options) { s.attributes[0].type = PSPLIT_UINT32; });
  expect(PSPLIT_ERROR_USAGE, "POSITION: 31 bits", [](Source s, Options) { s.attributes[0].bits = 31; });
  expect(PSPLIT_ERROR_USAGE, "POSITION: -2 bits", [](Source s, Options) { s.attributes[0].bits = -2; });
  expect(PSPLIT_ERROR_USAGE, "`reserved`", [](Source s, Options) { s.attributes[0].reserved = 1; });
  expect(PSPLIT_ERROR_USAGE, "two attributes have the name POSITION", [](Source s, Options) {
    s.attributes.push_back(s.attributes[0]);
    s.source.attributes = s.attributes.data();
    s.source.attribute_count = 2;
  });
  expect(PSPLIT_ERROR_USAGE, "kind 3 cannot be encoded",
         [](Source, Options options) { options.kind = PSPLIT_KIND_DRACO_FILE; });
  expect(PSPLIT_ERROR_USAGE, "speed 11", [](Source, Options options) { options.speed = 11; });
  expect(PSPLIT_ERROR_USAGE, "speed -1", [](Source, Options options) { options.speed = -1; });
  expect(PSPLIT_ERROR_USAGE, "color_bits: 0 bits", [](Source, Options options) { options.color_bits = 0; });
  expect(PSPLIT_ERROR_USAGE, "no flags 64", [](Source, Options options) { options.flags = 64; });
  expect(PSPLIT_ERROR_USAGE, "struct_size 8", [](Source, Options options) { options.struct_size = 8; });
  expect(PSPLIT_ERROR_USAGE, "struct_size 0", [](Source s, Options) { s.source.struct_size = 0; });
  expect(PSPLIT_ERROR_USAGE, "struct_size 1", [](Source s, Options) { s.attributes[0].struct_size = 1; });
  CSource source(mesh);
  psplit_encode_options options = default_options();
  options.kind = PSPLIT_KIND_DRACO;
  options.flags = PSPLIT_ENCODE_CONDENSE;
  EXPECT_EQ(encode(source.source, &options).code, PSPLIT_ERROR_USAGE);
  EXPECT_EQ(psplit_encode(nullptr, nullptr, nullptr, nullptr), PSPLIT_ERROR_USAGE);
  psplit_encoded* encoded = nullptr;
  EXPECT_EQ(psplit_encode(nullptr, nullptr, &encoded, nullptr), PSPLIT_ERROR_USAGE);
}

std::string text_of(const Handle<psplit_output>& output) {
  return {static_cast<const char*>(psplit_output_data(output.get())), psplit_output_size(output.get())};
}

// A square of two triangles with one attribute more.
Mesh square_with(Attribute attribute) {
  Mesh mesh{4, {{0, 1, 2}, {2, 1, 3}}, {Attribute{"POSITION", ComponentType::kFloat32, 3, false, {}}}};
  const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.25F};
  mesh.attributes[0].values.resize(sizeof(positions));
  std::memcpy(mesh.attributes[0].values.data(), positions, sizeof(positions));
  attribute.values.assign(4 * attribute.stride(), std::byte{0});
  if (attribute.component_type == ComponentType::kFloat32 && attribute.semantic == "TEXCOORD_0")
    std::memcpy(attribute.values.data(), positions, attribute.values.size());
  mesh.attributes.push_back(std::move(attribute));
  return mesh;
}

TEST(CEncode, WritesGlbFilesThatOpenAgain) {
  size_t written = 0;
  for (const psplit_kind kind : {PSPLIT_KIND_PATCHES, PSPLIT_KIND_DRACO})
    for (const auto& [name, mesh] : all_meshes()) {
      SCOPED_TRACE(name);
      psplit_encode_options options = default_options();
      options.kind = kind;
      const CSource source(mesh);
      const Result result = encode(source.source, &options);
      if (result.code != PSPLIT_OK) continue;
      psplit_output* made = nullptr;
      const psplit_code code = psplit_encoded_write_glb(result.encoded.get(), &made, nullptr);
      const Handle<psplit_output> glb(made);
      const bool has_types = std::ranges::all_of(mesh.attributes, [&](const Attribute& attribute) {
        const int count = attribute.component_count;
        const bool has_target = target_of(attribute.semantic).has_value();
        return (count <= 4 || count == 9 || count == 16) && (kind == PSPLIT_KIND_PATCHES || !has_target);
      });
      ASSERT_EQ(code == PSPLIT_OK, has_types);
      if (!has_types) continue;
      auto gltf_source = init<psplit_gltf_source>();
      gltf_source.data = psplit_output_data(glb.get());
      gltf_source.size = psplit_output_size(glb.get());
      psplit_gltf* opened = nullptr;
      psplit_error error = init<psplit_error>();
      ASSERT_EQ(psplit_gltf_open(&gltf_source, &opened, &error), PSPLIT_OK) << error.text;
      EXPECT_EQ(psplit_gltf_primitive_kind(opened, 0, 0), kind);
      psplit_mesh* primitive = nullptr;
      EXPECT_EQ(psplit_gltf_open_primitive(opened, 0, 0, &primitive, &error), PSPLIT_OK) << error.text;
      psplit_gltf_free(opened);
      const Handle<psplit_mesh> decoded(primitive);
      const psplit_mesh_info info = info_of(primitive);
      EXPECT_EQ(info.point_count, result.info.point_count);
      EXPECT_EQ(info.face_count, result.info.face_count);
      ASSERT_EQ(info.attribute_count, result.info.attribute_count);
      for (const Attribute& attribute : mesh.attributes)
        EXPECT_GE(psplit_mesh_find_name(primitive, attribute.semantic.c_str()), 0) << attribute.semantic;
      ++written;
    }
  EXPECT_GT(written, 40u);
}

TEST(CEncode, WritesTheJsonOfAPrimitive) {
  const Attribute integers{"_COUNT", ComponentType::kUint16, 1, false, {}};
  const CSource source(square_with(integers));
  psplit_encode_options options = default_options();
  options.position_bits = -1;
  const Result result = encode(source.source, &options);
  ASSERT_EQ(result.code, PSPLIT_OK) << result.error.text;
  psplit_output* made = nullptr;
  ASSERT_EQ(psplit_encoded_write_json(result.encoded.get(), 7, 3, &made, nullptr), PSPLIT_OK);
  const Handle<psplit_output> json(made);
  EXPECT_STREQ(
      text_of(json).c_str(),
      R"({"primitive":{"attributes":{"POSITION":7,"_COUNT":8},"indices":9,"extensions":)"
      R"({"KHR_draco_mesh_compression":{"bufferView":3,"attributes":{"POSITION":0,"_COUNT":1}}}},)"
      R"("accessors":[{"componentType":5126,"count":4,"type":"VEC3","min":[0.0,0.0,0.0],)"
      R"("max":[1.0,1.0,0.25]},{"componentType":5123,"count":4,"type":"SCALAR","min":[0],"max":[0]},)"
      R"({"componentType":5123,"count":6,"type":"SCALAR"}],"extensions":["KHR_draco_mesh_compression"]})");
  EXPECT_EQ(psplit_output_data(nullptr), nullptr);
  EXPECT_EQ(psplit_output_size(nullptr), 0u);
  EXPECT_EQ(psplit_encoded_write_json(nullptr, 0, 0, &made, nullptr), PSPLIT_ERROR_USAGE);
  EXPECT_EQ(made, nullptr);
}

TEST(CEncode, CloudsAreThoseOfTheEncoder) {
  for (const auto& [name, mesh] : all_meshes())
    for (const int32_t speed : {0, 5, 10}) {
      SCOPED_TRACE(name + ", speed " + std::to_string(speed));
      Mesh cloud{mesh.point_count, {}, mesh.attributes};
      EncodeOptions expected_options;
      expected_options.storage = Storage::kCloud;
      expected_options.encode_speed = speed;
      expected_options.keep_duplicates = true;
      const Expected<EncodedMesh> expected = psplit::encode(cloud, expected_options, ThreadPool(1));
      CSource source(std::move(cloud), 0);
      source.source.indices = nullptr;
      psplit_encode_options options = default_options();
      options.flags = PSPLIT_ENCODE_POINTS;
      options.speed = speed;
      const Result result = encode(source.source, &options);
      ASSERT_EQ(result.code == PSPLIT_OK, expected.ok()) << result.error.text;
      if (!expected) continue;
      EXPECT_EQ(result.info.kind, PSPLIT_KIND_DRACO_FILE);
      EXPECT_EQ(result.bytes(), expected->pieces[0].bytes);
      EXPECT_EQ(result.source_points(), expected->pieces[0].source_point);
      EXPECT_EQ(result.info.face_count, 0u);
      EXPECT_EQ(result.info.point_count, mesh.point_count);
      EXPECT_GE(result.info.position_error, 0);
      psplit_output* made = nullptr;
      EXPECT_EQ(psplit_encoded_write_json(result.encoded.get(), 0, 0, &made, nullptr),
                PSPLIT_ERROR_UNSUPPORTED);
    }
}

TEST(CEncode, RefusesWhatIsNoCloud) {
  CSource source(all_meshes()[0].mesh);
  const auto code_of = [&](uint32_t flags, psplit_kind kind) {
    psplit_encode_options options = default_options();
    options.flags = PSPLIT_ENCODE_POINTS | flags;
    options.kind = kind;
    return encode(source.source, &options).code;
  };
  EXPECT_EQ(code_of(0, PSPLIT_KIND_NONE), PSPLIT_ERROR_USAGE);  // there are indices
  source.source.indices = nullptr;
  source.source.indices_size = 0;
  EXPECT_EQ(code_of(0, PSPLIT_KIND_PATCHES), PSPLIT_ERROR_USAGE);
  EXPECT_EQ(code_of(PSPLIT_ENCODE_CONDENSE, PSPLIT_KIND_NONE), PSPLIT_ERROR_USAGE);
  EXPECT_EQ(code_of(PSPLIT_ENCODE_WITHOUT_VERIFYING, PSPLIT_KIND_DRACO), PSPLIT_OK);
  source.source.point_count = 0;
  EXPECT_NE(code_of(0, PSPLIT_KIND_NONE), PSPLIT_OK);
}

TEST(CEncode, RefusesJsonThatGltfDoesNotHave) {
  const auto code_of = [](Attribute attribute, psplit_kind kind) {
    const CSource source(square_with(std::move(attribute)));
    psplit_encode_options options = default_options();
    options.kind = kind;
    const Result result = encode(source.source, &options);
    EXPECT_EQ(result.code, PSPLIT_OK) << result.error.text;
    psplit_output* made = nullptr;
    const psplit_code code = psplit_encoded_write_json(result.encoded.get(), 0, 0, &made, nullptr);
    psplit_output_free(made);
    return code;
  };
  const Attribute target{"targets/0/POSITION", ComponentType::kFloat32, 3, false, {}};
  EXPECT_EQ(code_of(target, PSPLIT_KIND_PATCHES), PSPLIT_OK);
  EXPECT_EQ(code_of(target, PSPLIT_KIND_DRACO), PSPLIT_ERROR_UNSUPPORTED);
  const Attribute far{"targets/9999999/POSITION", ComponentType::kFloat32, 3, false, {}};
  EXPECT_EQ(code_of(far, PSPLIT_KIND_PATCHES), PSPLIT_ERROR_UNSUPPORTED);
  const Attribute wide{"_FIVE", ComponentType::kFloat32, 5, false, {}};
  EXPECT_EQ(code_of(wide, PSPLIT_KIND_PATCHES), PSPLIT_ERROR_UNSUPPORTED);
}

TEST(CEncode, SaysHowEachAttributeIsStored) {
  const auto stored = [](Attribute attribute, int32_t bits) {
    CSource source(square_with(std::move(attribute)));
    source.attributes[1].bits = bits;
    const Result result = encode(source.source, nullptr);
    EXPECT_EQ(result.code, PSPLIT_OK) << result.error.text;
    auto quantization = init<psplit_quantization>();
    EXPECT_EQ(psplit_encoded_get_quantization(result.encoded.get(), 1, &quantization, nullptr), PSPLIT_OK);
    EXPECT_EQ(psplit_encoded_get_quantization(result.encoded.get(), 2, &quantization, nullptr),
              PSPLIT_ERROR_USAGE);
    EXPECT_EQ(psplit_encoded_reason(result.encoded.get(), 2), nullptr);
    EXPECT_EQ(quantization.origin_count > 0, quantization.bits > 0);
    return std::to_string(quantization.bits) + ": " + psplit_encoded_reason(result.encoded.get(), 1);
  };
  const Attribute texcoords{"TEXCOORD_0", ComponentType::kFloat32, 2, false, {}};
  EXPECT_EQ(stored(texcoords, 0), "12: TEXCOORD_0 gets 12 bits, as the options say");
  EXPECT_EQ(stored(texcoords, 9), "9: TEXCOORD_0 gets 9 bits, as its own bits say");
  EXPECT_EQ(stored(texcoords, -1), "0: TEXCOORD_0 is kept exactly, as its bits say");
  EXPECT_EQ(stored({"_FEATURE_ID_0", ComponentType::kFloat32, 1, false, {}}, 0),
            "1: _FEATURE_ID_0 is kept exactly, on a grid of 1 bit that has all of its values");
  EXPECT_EQ(stored({"_COUNT", ComponentType::kUint16, 1, false, {}}, 0),
            "0: _COUNT is kept exactly: it has integers");
  EXPECT_EQ(stored({"NORMAL", ComponentType::kFloat32, 3, false, {}}, 0),
            "0: NORMAL is kept exactly, in at most 48 bytes instead of 15: 4 of 4 points have no unit vector");
}

}  // namespace
}  // namespace psplit
