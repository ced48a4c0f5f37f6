// Wrong arguments of the C interface: sizes of structs, null pointers, buffers that are too small.
#include <cstring>
#include <set>

#include "src/container/patch_container.h"
#include "tests/c/handles.h"
#include "tests/support/expect.h"
#include "tests/support/patched_samples.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

const PatchedSample& grid_sample() {
  static const PatchedSample made = [] {
    const Mesh mesh = make_grid(12, 12);
    return encode_sample("grid", mesh, fine_codings(mesh, 12), {.patch_count = 3}, ThreadPool(2));
  }();
  return made;
}

Handle<psplit_mesh> open_grid() {
  return must_open(PSPLIT_KIND_PATCHES, grid_sample().encoded.pieces[0].bytes, grid_sample().requests);
}

// A struct with bytes after it, as a newer program has it.
template <typename Struct>
struct Grown {
  Struct now = init<Struct>();
  unsigned char later[24] = {};

  Grown() { now.struct_size = sizeof(Grown); }
};

// call(struct*) returns a code. The struct is right but for its size.
template <typename Struct, typename Call>
void expect_sizes(const Struct& right, Call call) {
  Struct made = right;
  EXPECT_EQ(call(&made), PSPLIT_OK);
  for (const uint32_t size :
       {0u, 4u, static_cast<uint32_t>(sizeof(Struct) - 1), static_cast<uint32_t>(sizeof(Struct) + 1)}) {
    made = right;
    made.struct_size = size;
    EXPECT_EQ(call(&made), PSPLIT_ERROR_USAGE) << size;
  }
  EXPECT_EQ(call(static_cast<Struct*>(nullptr)), PSPLIT_ERROR_USAGE);
  Grown<Struct> grown;
  grown.now = right;
  grown.now.struct_size = sizeof(grown);
  EXPECT_EQ(call(&grown.now), PSPLIT_OK);
}
// As above, for a struct that is read: members that a newer program sets are not ignored.
template <typename Struct, typename Call>
void expect_read(const Struct& right, Call call) {
  expect_sizes(right, call);
  Grown<Struct> grown;
  grown.now = right;
  grown.now.struct_size = sizeof(grown);
  grown.later[23] = 1;
  EXPECT_EQ(call(&grown.now), PSPLIT_ERROR_UNSUPPORTED);
}
// As above, for results: members that the library does not know become 0.
template <typename Struct, typename Call>
void expect_written(Call call) {
  expect_sizes(init<Struct>(), call);
  Grown<Struct> grown;
  std::memset(grown.later, 0xff, sizeof(grown.later));
  EXPECT_EQ(call(&grown.now), PSPLIT_OK);
  EXPECT_EQ(grown.now.struct_size, sizeof(grown));
  for (const unsigned char byte : grown.later) EXPECT_EQ(byte, 0);
}

psplit_source right_source(const std::vector<psplit_attribute_request>& requests) {
  auto source = init<psplit_source>();
  source.kind = PSPLIT_KIND_PATCHES;
  source.data = grid_sample().encoded.pieces[0].bytes.data();
  source.size = grid_sample().encoded.pieces[0].bytes.size();
  source.attributes = requests.data();
  source.attribute_count = static_cast<uint32_t>(requests.size());
  return source;
}
psplit_code try_open(const psplit_source* source, psplit_error* error = nullptr) {
  psplit_mesh* mesh = reinterpret_cast<psplit_mesh*>(1);
  const psplit_code code = psplit_mesh_open(source, &mesh, error);
  EXPECT_EQ(code == PSPLIT_OK, mesh != nullptr);
  psplit_mesh_free(mesh);
  return code;
}

TEST(CUsage, StructsThatAreReadHaveTheirSize) {
  const auto requests = c_requests(grid_sample().requests);
  expect_read(right_source(requests), [](const psplit_source* source) { return try_open(source); });
  expect_read(requests[0], [](const psplit_attribute_request* request) {
    psplit_source source = right_source({});
    source.attributes = request;
    source.attribute_count = 1;
    return try_open(&source);
  });
  const Handle<psplit_mesh> mesh = open_grid();
  const psplit_mesh_info info = info_of(mesh.get());
  Buffers memory(grid_sample().requests, info.point_count, info.face_count);
  CBuffers buffers(memory.out);
  expect_read(buffers.buffers,
              [&](const psplit_buffers* out) { return psplit_mesh_decode(mesh.get(), out, nullptr, nullptr); });
  expect_read(buffers.attributes[0], [&](const psplit_attribute_buffer* attribute) {
    psplit_buffers out = buffers.buffers;
    out.attributes = attribute;
    return psplit_mesh_decode(mesh.get(), &out, nullptr, nullptr);
  });
  expect_read(init<psplit_run>(), [&](const psplit_run* run) {
    // NULL stands for the defaults.
    if (run == nullptr) return psplit_code{PSPLIT_ERROR_USAGE};
    return psplit_mesh_decode(mesh.get(), &buffers.buffers, run, nullptr);
  });
  auto job = init<psplit_job>();
  job.mesh = mesh.get();
  job.buffers = &buffers.buffers;
  expect_read(job, [](psplit_job* jobs) { return psplit_decode_meshes(jobs, 1, nullptr, nullptr); });
}

TEST(CUsage, StructsThatAreWrittenHaveTheirSize) {
  const Handle<psplit_mesh> mesh = open_grid();
  expect_written<psplit_mesh_info>(
      [&](psplit_mesh_info* info) { return psplit_mesh_get_info(mesh.get(), info, nullptr); });
  expect_written<psplit_attribute_info>(
      [&](psplit_attribute_info* info) { return psplit_mesh_get_attribute(mesh.get(), 0, info, nullptr); });
  expect_written<psplit_patch_info>(
      [&](psplit_patch_info* info) { return psplit_mesh_get_patch(mesh.get(), 0, info, nullptr); });
  expect_written<psplit_quantization>([&](psplit_quantization* quantization) {
    return psplit_mesh_get_quantization(mesh.get(), 0, quantization, nullptr);
  });
}

TEST(CUsage, ElementsOfAnArrayHaveTheSizeOfTheFirst) {
  const AttributeRequest position = grid_sample().requests[0];
  AttributeRequest again = position;
  again.semantic = "_AGAIN";
  const std::vector<AttributeRequest> two = {position, again};
  const std::vector<psplit_attribute_request> right = c_requests(two);
  EXPECT_EQ(try_open(std::make_unique<psplit_source>(right_source(right)).get()), PSPLIT_OK);
  std::vector<psplit_attribute_request> wrong = right;
  wrong[1].struct_size -= 8;
  psplit_source source = right_source(wrong);
  auto error = init<psplit_error>();
  EXPECT_EQ(try_open(&source, &error), PSPLIT_ERROR_USAGE);
  // Larger elements are as far apart as they say.
  Grown<psplit_attribute_request> grown[2];
  for (int i = 0; i < 2; ++i) {
    grown[i].now = right[static_cast<size_t>(i)];
    grown[i].now.struct_size = sizeof(grown[i]);
  }
  source.attributes = &grown[0].now;
  psplit_mesh* mesh = nullptr;
  ASSERT_EQ(psplit_mesh_open(&source, &mesh, &error), PSPLIT_OK) << error.text;
  EXPECT_EQ(psplit_mesh_find_name(mesh, "_AGAIN"), 1);
  psplit_mesh_free(mesh);
  grown[1].now.struct_size -= 8;
  EXPECT_EQ(try_open(&source, &error), PSPLIT_ERROR_USAGE);
  EXPECT_STREQ(error.text, "psplit_attribute_request: elements of an array have different struct_sizes");
}

TEST(CUsage, ErrorsAreWrittenIntoRightStructsOnly) {
  auto error = init<psplit_error>();
  error.struct_size = 0;
  error.code = 77;
  EXPECT_EQ(psplit_mesh_open(nullptr, nullptr, &error), PSPLIT_ERROR_USAGE);
  EXPECT_EQ(error.code, 77);
  error.struct_size = sizeof(error);
  EXPECT_EQ(psplit_mesh_open(nullptr, nullptr, &error), PSPLIT_ERROR_USAGE);
  EXPECT_EQ(error.code, PSPLIT_ERROR_USAGE);
  EXPECT_EQ(error.struct_size, sizeof(error));
  EXPECT_NE(error.text[0], 0);
  EXPECT_EQ(error.patch, -1);
}

TEST(CUsage, TextsAreCutBetweenCharacters) {
  for (const size_t shift : {0u, 1u}) {
    std::string name(shift, 'x');
    for (int i = 0; i < 400; ++i) name += "\xc3\xa9";
    AttributeRequest request = grid_sample().requests[0];
    request.semantic = name;
    std::vector<psplit_attribute_request> requests = c_requests({&request, 1});
    requests[0].type = 99;
    const psplit_source source = right_source(requests);
    auto error = init<psplit_error>();
    std::memset(error.text, 'z', sizeof(error.text));
    EXPECT_EQ(try_open(&source, &error), PSPLIT_ERROR_UNSUPPORTED);
    const std::string text = error.text;
    EXPECT_EQ(text.size(), shift == 0 ? 478u : 479u);
    EXPECT_EQ(text, name.substr(0, text.size()));
  }
}

TEST(CUsage, NullHandlesAreErrorsOrEmpty) {
  auto error = init<psplit_error>();
  auto info = init<psplit_mesh_info>();
  auto attribute = init<psplit_attribute_info>();
  auto patch = init<psplit_patch_info>();
  auto quantization = init<psplit_quantization>();
  auto buffers = init<psplit_buffers>();
  auto encoded_info = init<psplit_encoded_info>();
  auto request = init<psplit_attribute_request>();
  const psplit_code codes[] = {
      psplit_mesh_get_info(nullptr, &info, &error),
      psplit_mesh_get_attribute(nullptr, 0, &attribute, &error),
      psplit_mesh_get_patch(nullptr, 0, &patch, &error),
      psplit_mesh_get_quantization(nullptr, 0, &quantization, &error),
      psplit_mesh_decode(nullptr, &buffers, nullptr, &error),
      psplit_mesh_decode_patch(nullptr, 0, &buffers, nullptr, &error),
      psplit_gltf_open(nullptr, nullptr, &error),
      psplit_gltf_set_buffer(nullptr, 0, "", 0, &error),
      psplit_gltf_open_primitive(nullptr, 0, 0, nullptr, &error),
      psplit_pool_create(1, nullptr, &error),
      psplit_stop_create(nullptr, &error),
      psplit_encoded_get_info(nullptr, &encoded_info, &error),
      psplit_encoded_get_attribute(nullptr, 0, &request, &error),
  };
  for (const psplit_code code : codes) EXPECT_EQ(code, PSPLIT_ERROR_USAGE);
  EXPECT_EQ(psplit_mesh_find_name(nullptr, "POSITION"), -1);
  EXPECT_EQ(psplit_mesh_find_id(nullptr, 0), -1);
  EXPECT_EQ(psplit_mesh_find_semantic(nullptr, PSPLIT_POSITION, 0), -1);
  EXPECT_EQ(psplit_mesh_find_name(open_grid().get(), nullptr), -1);
  EXPECT_EQ(psplit_pool_threads(nullptr), 0);
  EXPECT_EQ(psplit_gltf_mesh_count(nullptr), 0u);
  EXPECT_EQ(psplit_gltf_primitive_count(nullptr, 0), 0u);
  EXPECT_EQ(psplit_gltf_primitive_kind(nullptr, 0, 0), PSPLIT_KIND_NONE);
  EXPECT_EQ(psplit_gltf_buffer_count(nullptr), 0u);
  EXPECT_EQ(psplit_gltf_buffer_uri(nullptr, 0), nullptr);
  psplit_mesh_free(nullptr);
  psplit_gltf_free(nullptr);
  psplit_pool_free(nullptr);
  psplit_stop_free(nullptr);
  psplit_stop_set(nullptr, 1);
  psplit_encoded_free(nullptr);
  psplit_encode_options_init(nullptr);
}

TEST(CUsage, WrongSourcesAreErrors) {
  const auto requests = c_requests(grid_sample().requests);
  auto error = init<psplit_error>();
  const auto expect = [&](psplit_code code, const char* text, auto change) {
    std::vector<psplit_attribute_request> changed = requests;
    psplit_source source = right_source(changed);
    change(source, changed[0]);
    EXPECT_EQ(try_open(&source, &error), code);
    EXPECT_NE(std::string(error.text).find(text), std::string::npos) << error.text << ", not " << text;
  };
  using Source = psplit_source&;
  using Request = psplit_attribute_request&;
  expect(PSPLIT_OK, "", [](Source, Request) {});
  expect(PSPLIT_ERROR_USAGE, "kind 7 cannot be opened", [](Source source, Request) { source.kind = 7; });
  expect(PSPLIT_ERROR_USAGE, "kind 0 cannot be opened", [](Source source, Request) { source.kind = 0; });
  expect(PSPLIT_ERROR_USAGE, "no flags 2", [](Source source, Request) { source.flags = PSPLIT_INTEGERS; });
  expect(PSPLIT_ERROR_USAGE, "the bytes are null", [](Source source, Request) { source.data = nullptr; });
  expect(PSPLIT_ERROR_USAGE, "psplit_attribute_request is null",
         [](Source source, Request) { source.attributes = nullptr; });
  expect(PSPLIT_ERROR_USAGE, "takes no attributes",
         [](Source source, Request) { source.kind = PSPLIT_KIND_DRACO_FILE; });
  expect(PSPLIT_ERROR_INVALID_INPUT, "the accessors have 5 points",
         [](Source source, Request) { source.point_count = 5; });
  expect(PSPLIT_ERROR_USAGE, "no name", [](Source, Request request) { request.name = nullptr; });
  expect(PSPLIT_ERROR_USAGE, "`reserved`", [](Source, Request request) { request.reserved = 1; });
  expect(PSPLIT_ERROR_UNSUPPORTED, "POSITION has the type 7",
         [](Source, Request request) { request.type = PSPLIT_INT64; });
  expect(PSPLIT_ERROR_INVALID_INPUT, "POSITION has 0 components",
         [](Source, Request request) { request.components = 0; });
  expect(PSPLIT_ERROR_INVALID_INPUT, "POSITION has 259 components",
         [](Source, Request request) { request.components = 259; });
}

TEST(CUsage, BuffersMustFit) {
  const auto expect_all = [](const psplit_mesh* mesh, std::span<const AttributeRequest> requests) {
    const psplit_mesh_info info = info_of(mesh);
    auto error = init<psplit_error>();
    const auto expect = [&](psplit_code code, const char* text, auto change) {
      Buffers memory(requests, info.point_count, info.face_count);
      CBuffers out(memory.out);
      change(out.buffers, out.attributes[0]);
      EXPECT_EQ(psplit_mesh_decode(mesh, &out.buffers, nullptr, &error), code);
      EXPECT_NE(std::string(error.text).find(text), std::string::npos) << error.text << ", not " << text;
      if (code == PSPLIT_OK) return;
      for (const std::byte byte : memory.values[0]) ASSERT_EQ(byte, Buffers::kUntouched);
    };
    using Out = psplit_buffers&;
    using Attribute = psplit_attribute_buffer&;
    expect(PSPLIT_OK, "", [](Out, Attribute) {});
    expect(PSPLIT_OK, "", [](Out, Attribute attribute) { attribute.stride = 0; });
    expect(PSPLIT_ERROR_USAGE, "the buffer of POSITION has no room",
           [](Out, Attribute attribute) { --attribute.size; });
    expect(PSPLIT_ERROR_USAGE, "the buffer of POSITION has no room",
           [](Out, Attribute attribute) { attribute.stride = SIZE_MAX; });
    expect(PSPLIT_ERROR_USAGE, "the stride of POSITION",
           [](Out, Attribute attribute) { attribute.stride = 11; });
    expect(PSPLIT_ERROR_USAGE, "is null", [](Out, Attribute attribute) { attribute.data = nullptr; });
    expect(PSPLIT_ERROR_USAGE, "`reserved`", [](Out, Attribute attribute) { attribute.reserved = 1; });
    expect(PSPLIT_ERROR_USAGE, "`reserved`", [](Out out, Attribute) { out.reserved = 1; });
    expect(PSPLIT_ERROR_USAGE, "no room for", [](Out out, Attribute) { --out.indices_size; });
    expect(PSPLIT_ERROR_USAGE, "is null", [](Out out, Attribute) { out.indices = nullptr; });
    expect(PSPLIT_ERROR_USAGE, "no room for",
           [](Out out, Attribute) { out.indices = nullptr, out.indices_size = 0; });
    expect(PSPLIT_ERROR_USAGE, "not aligned",
           [](Out out, Attribute) { out.indices = static_cast<char*>(out.indices) + 1; });
    expect(PSPLIT_ERROR_USAGE, "indices of 1 bytes", [](Out out, Attribute) { out.index_size = 1; });
    expect(PSPLIT_ERROR_USAGE, "buffers for", [](Out out, Attribute) { out.attribute_count = 7; });
    expect(PSPLIT_ERROR_USAGE, "psplit_attribute_buffer is null",
           [](Out out, Attribute) { out.attributes = nullptr; });
  };
  expect_all(open_grid().get(), grid_sample().requests);
  const std::vector<uint8_t> stream = [] {
    const PatchContainer container = must(open_container(grid_sample().encoded.pieces[0].bytes));
    return std::vector<uint8_t>(container.streams[0].begin(), container.streams[0].end());
  }();
  expect_all(must_open(PSPLIT_KIND_DRACO_FILE, stream).get(), grid_sample().requests);
}

TEST(CUsage, ThreadsHaveALimit) {
  auto error = init<psplit_error>();
  for (const int32_t threads : {-1, 4097}) {
    psplit_pool* pool = reinterpret_cast<psplit_pool*>(1);
    EXPECT_EQ(psplit_pool_create(threads, &pool, &error), PSPLIT_ERROR_USAGE);
    EXPECT_EQ(pool, nullptr);
    auto run = init<psplit_run>();
    run.threads = threads;
    auto buffers = init<psplit_buffers>();
    EXPECT_EQ(psplit_mesh_decode(open_grid().get(), &buffers, &run, &error), PSPLIT_ERROR_USAGE);
    EXPECT_NE(std::string(error.text).find("threads"), std::string::npos);
  }
}

TEST(CUsage, CodesHaveNames) {
  std::set<std::string> names;
  for (const psplit_code code :
       {PSPLIT_OK, PSPLIT_ERROR_USAGE, PSPLIT_ERROR_INVALID_INPUT, PSPLIT_ERROR_FAILURE,
        PSPLIT_ERROR_UNSUPPORTED, PSPLIT_ERROR_CANCELLED, PSPLIT_ERROR_NO_MEMORY})
    names.insert(psplit_code_name(code));
  EXPECT_EQ(names.size(), 7u);
  EXPECT_STREQ(psplit_code_name(1234), "unknown");
  EXPECT_FALSE(names.contains("unknown"));
}

}  // namespace
}  // namespace psplit
