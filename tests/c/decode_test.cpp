// Decoding through the C interface gives the bits of the C++ interface and of libdraco.
#include "psplit/decode.h"

#include <array>
#include <atomic>
#include <thread>

#include "psplit/encode.h"
#include "psplit/loader.h"
#include "src/container/patch_container.h"
#include "tests/c/handles.h"
#include "tests/support/default_codings.h"
#include "tests/support/draco_clouds.h"
#include "tests/support/expect.h"
#include "tests/support/mutants.h"
#include "tests/support/older_stream.h"
#include "tests/support/patched_samples.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/same_bits.h"
#include "tests/support/sanitizers.h"
#include "tests/support/stock_stream.h"

namespace psplit {
namespace {

const std::vector<PatchedSample>& samples() { return all_samples(ThreadPool(2)); }

const PatchedSample& sample_of_many_patches() {
  for (const PatchedSample& sample : samples())
    if (sample.encoded.statistics.patch_count > 4 && sample.requests.size() > 1) return sample;
  ADD_FAILURE() << "no sample has many patches";
  return samples().front();
}

Handle<psplit_mesh> open_sample(const PatchedSample& sample) {
  return must_open(PSPLIT_KIND_PATCHES, sample.encoded.pieces[0].bytes, sample.requests);
}

Handle<psplit_pool> make_pool(int32_t threads) {
  psplit_pool* pool = nullptr;
  EXPECT_EQ(psplit_pool_create(threads, &pool, nullptr), PSPLIT_OK);
  return Handle<psplit_pool>(pool);
}

TEST(CDecode, ContainersAreTheBackendsMeshes) {
  const Handle<psplit_pool> pool = make_pool(3);
  for (const PatchedSample& sample : samples()) {
    SCOPED_TRACE(sample.name);
    const Mesh& expected = sample.mesh;
    const Handle<psplit_mesh> mesh = open_sample(sample);
    const psplit_mesh_info info = info_of(mesh.get());
    EXPECT_EQ(info.kind, PSPLIT_KIND_PATCHES);
    EXPECT_EQ(info.coding, PSPLIT_CODING_UNKNOWN);
    ASSERT_EQ(info.point_count, expected.point_count);
    ASSERT_EQ(info.face_count, expected.faces.size());
    ASSERT_EQ(info.attribute_count, sample.requests.size());
    EXPECT_EQ(info.patch_count, sample.encoded.pieces[0].entries.size());
    for (uint32_t k = 0; k < info.attribute_count; ++k) {
      const psplit_attribute_info attribute = attribute_of(mesh.get(), k);
      EXPECT_EQ(attribute.name, sample.requests[k].semantic);
      EXPECT_EQ(attribute.unique_id, sample.requests[k].unique_id);
      EXPECT_EQ(attribute.value_size, sample.requests[k].value_bytes());
      EXPECT_EQ(psplit_mesh_find_name(mesh.get(), attribute.name), static_cast<int32_t>(k));
      EXPECT_EQ(psplit_mesh_find_id(mesh.get(), attribute.unique_id), static_cast<int32_t>(k));
    }
    for (const uint32_t index_size : {2u, 4u})
      for (const size_t gap : {0u, 3u}) {
        if (index_size < info.least_index_size) continue;
        Buffers buffers(sample.requests, info.point_count, info.face_count, index_size, gap);
        CBuffers out(buffers.out);
        auto run = init<psplit_run>();
        run.threads = 1;
        if (gap != 0) run.pool = pool.get();
        auto error = init<psplit_error>();
        EXPECT_EQ(psplit_mesh_decode(mesh.get(), &out.buffers, &run, &error), PSPLIT_OK) << error.text;
        EXPECT_TRUE(same_bits(buffers.mesh(sample.requests, info.point_count), expected));
      }
  }
}

TEST(CDecode, PatchesAloneAreThoseOfTheLoader) {
  for (const PatchedSample& sample : samples()) {
    SCOPED_TRACE(sample.name);
    const CompressedPrimitive primitive =
        must(CompressedPrimitive::open({sample.encoded.pieces[0].bytes, sample.requests}));
    const Handle<psplit_mesh> mesh = open_sample(sample);
    ASSERT_EQ(info_of(mesh.get()).patch_count, primitive.patch_count());
    EXPECT_EQ(info_of(mesh.get()).has_residue, primitive.has_residue());
    for (uint32_t n = 0; n < primitive.patch_count(); ++n) {
      const PatchSizes sizes = primitive.patch(n);
      auto patch = init<psplit_patch_info>();
      ASSERT_EQ(psplit_mesh_get_patch(mesh.get(), n, &patch, nullptr), PSPLIT_OK);
      EXPECT_EQ(patch.face_count, sizes.face_count);
      EXPECT_EQ(patch.point_count, sizes.point_count);
      EXPECT_EQ(patch.stream_size, sizes.stream_bytes);
      EXPECT_EQ(patch.first_face, sizes.first_face);
      EXPECT_EQ(patch.first_owned_point, sizes.first_owned_point);
      EXPECT_EQ(patch.owned_point_count, sizes.owned_point_count);
      EXPECT_EQ(patch.is_residue, primitive.has_residue() && n + 1 == primitive.patch_count());
      Buffers expected(sample.requests, sizes.point_count, sizes.face_count);
      Buffers buffers(sample.requests, sizes.point_count, sizes.face_count);
      must(primitive.decode_patch(n, expected.out));
      const CBuffers out(buffers.out);
      auto run = init<psplit_run>();
      run.threads = 1;
      EXPECT_EQ(psplit_mesh_decode_patch(mesh.get(), n, &out.buffers, &run, nullptr), PSPLIT_OK);
      EXPECT_EQ(buffers.indices, expected.indices);
      EXPECT_EQ(buffers.values, expected.values);
    }
    auto error = init<psplit_error>();
    auto patch = init<psplit_patch_info>();
    EXPECT_EQ(psplit_mesh_get_patch(mesh.get(), primitive.patch_count(), &patch, &error), PSPLIT_ERROR_USAGE);
    Buffers none({}, 0, 0);
    const CBuffers out(none.out);
    EXPECT_EQ(psplit_mesh_decode_patch(mesh.get(), primitive.patch_count(), &out.buffers, nullptr, &error),
              PSPLIT_ERROR_USAGE);
  }
}

TEST(CDecode, AttributesThatAreNotWantedAreLeftOut) {
  const PatchedSample& sample = sample_of_many_patches();
  const Handle<psplit_mesh> mesh = open_sample(sample);
  const psplit_mesh_info info = info_of(mesh.get());
  for (uint32_t wanted = 0; wanted < info.attribute_count; ++wanted) {
    Buffers buffers(sample.requests, info.point_count, info.face_count, 4, 1);
    CBuffers out(buffers.out);
    for (uint32_t k = 0; k < info.attribute_count; ++k)
      if (k != wanted) out.attributes[k].data = nullptr, out.attributes[k].size = 0;
    ASSERT_EQ(psplit_mesh_decode(mesh.get(), &out.buffers, nullptr, nullptr), PSPLIT_OK);
    const Mesh decoded = buffers.mesh(sample.requests, info.point_count);
    EXPECT_EQ(decoded.faces, sample.mesh.faces);
    for (uint32_t k = 0; k < info.attribute_count; ++k)
      EXPECT_EQ(decoded.attributes[k].values == sample.mesh.attributes[k].values, k == wanted);
  }
  // Indices alone.
  Buffers buffers({}, info.point_count, info.face_count);
  const CBuffers out(buffers.out);
  ASSERT_EQ(psplit_mesh_decode(mesh.get(), &out.buffers, nullptr, nullptr), PSPLIT_OK);
  EXPECT_EQ(buffers.mesh({}, info.point_count).faces, sample.mesh.faces);
}

// All attributes of a whole stream, with a gap after each value. `code` becomes that of decoding.
RawMesh decode_file(const psplit_mesh* mesh, size_t gap, psplit_code& code) {
  const psplit_mesh_info info = info_of(mesh);
  RawMesh raw;
  raw.point_count = info.point_count;
  raw.faces.resize(info.face_count);
  PrimitiveBuffers out{raw.faces, 4};
  std::vector<std::vector<uint8_t>> values(info.attribute_count);
  for (uint32_t k = 0; k < info.attribute_count; ++k) {
    const psplit_attribute_info attribute = attribute_of(mesh, k);
    values[k].resize(info.point_count * (attribute.value_size + gap), 0xa5);
    out.attributes.push_back({values[k], gap == 0 ? 0 : attribute.value_size + gap});
    raw.attributes.push_back({attribute.unique_id,
                              attribute.semantic,
                              attribute.type,
                              static_cast<int>(attribute.components),
                              attribute.normalized != 0,
                              {}});
  }
  const CBuffers buffers(out);
  auto error = init<psplit_error>();
  code = psplit_mesh_decode(mesh, &buffers.buffers, nullptr, &error);
  for (uint32_t k = 0; k < info.attribute_count; ++k) {
    const size_t size = attribute_of(mesh, k).value_size;
    for (size_t at = 0; at < values[k].size(); at += size + gap) {
      const auto value = values[k].begin() + static_cast<std::ptrdiff_t>(at);
      raw.attributes[k].point_values.insert(raw.attributes[k].point_values.end(), value,
                                            value + static_cast<std::ptrdiff_t>(size));
      for (size_t byte = size; byte < size + gap; ++byte) EXPECT_EQ(values[k][at + byte], 0xa5);
    }
  }
  return raw;
}

RawMesh decode_file(const psplit_mesh* mesh, size_t gap) {
  psplit_code code = PSPLIT_OK;
  RawMesh raw = decode_file(mesh, gap, code);
  EXPECT_EQ(code, PSPLIT_OK);
  return raw;
}

// Whether the stream is one that we decode: libdraco knows older ones too.
bool is_decoded(const Opened& opened) { return opened.code != PSPLIT_ERROR_UNSUPPORTED; }

TEST(CDecode, WholeStreamsAreLibdracosInTheirOwnTypes) {
  size_t decoded = 0;
  const auto expect_decoded = [&](const DracoStream& stream, const std::optional<RawMesh>& expected) {
    SCOPED_TRACE(stream.name);
    const Opened opened = open_bytes(PSPLIT_KIND_DRACO_FILE, stream.bytes);
    if (!is_decoded(opened)) return;
    ASSERT_EQ(opened.code, PSPLIT_OK) << opened.error.text;
    EXPECT_EQ(info_of(opened.mesh.get()).patch_count, 1u);
    EXPECT_EQ(decode_file(opened.mesh.get(), decoded % 3), must(expected));
    ++decoded;
  };
  for (const DracoStream& stream : small_draco_streams())
    expect_decoded(stream, decode_with_libdraco(stream.bytes));
  EXPECT_GT(decoded, 100u);
  const size_t meshes = decoded;
  for (const DracoStream& cloud : small_draco_clouds())
    expect_decoded(cloud, decode_cloud_with_libdraco(cloud.bytes));
  EXPECT_GT(decoded, meshes + 100);
}

TEST(CDecode, IntegersAreThoseOfTheStream) {
  size_t count = 0;
  for (const DracoStream& stream : small_draco_streams()) {
    SCOPED_TRACE(stream.name);
    const Opened opened = open_bytes(PSPLIT_KIND_DRACO_FILE, stream.bytes, {}, PSPLIT_INTEGERS);
    if (!is_decoded(opened)) continue;
    const RawMesh raw = decode_file(opened.mesh.get(), 0);
    const RawMesh expected = must(decode_with_libdraco(stream.bytes, AttributeTransforms::kSkip));
    const DracoGeometry geometry = must(decode_geometry(stream.bytes, true));
    EXPECT_EQ(raw.faces, expected.faces);
    for (uint32_t k = 0; k < raw.attributes.size(); ++k) {
      const psplit_attribute_info attribute = attribute_of(opened.mesh.get(), k);
      EXPECT_EQ(attribute.is_integers != 0, geometry.attributes[k].are_integers);
      const auto quantization = [&] {
        auto found = init<psplit_quantization>();
        EXPECT_EQ(psplit_mesh_get_quantization(opened.mesh.get(), k, &found, nullptr), PSPLIT_OK);
        return found;
      }();
      const StreamAttribute& described = geometry.attributes[k].description;
      EXPECT_EQ(quantization.bits, described.bits);
      EXPECT_EQ(quantization.range, described.range);
      EXPECT_EQ(std::vector(quantization.origin, quantization.origin + quantization.origin_count),
                described.origin);
      if (quantization.bits == 0) continue;
      EXPECT_EQ(attribute.type, PSPLIT_INT32);
      EXPECT_EQ(raw.attributes[k].point_values, expected.attributes[k].point_values);
      ++count;
    }
  }
  EXPECT_GT(count, 100u);
}

TEST(CDecode, WholeStreamsFindAttributesBySemantic) {
  for (const DracoStream& stream : small_draco_streams()) {
    const Opened opened = open_bytes(PSPLIT_KIND_DRACO_FILE, stream.bytes);
    if (!is_decoded(opened)) continue;
    const psplit_mesh* const mesh = opened.mesh.get();
    std::array<uint32_t, 5> seen{};
    for (uint32_t k = 0; k < info_of(mesh).attribute_count; ++k) {
      const psplit_attribute_info attribute = attribute_of(mesh, k);
      const auto semantic = static_cast<size_t>(attribute.semantic);
      ASSERT_LT(semantic, seen.size());
      EXPECT_EQ(psplit_mesh_find_semantic(mesh, attribute.semantic, seen[semantic]++), static_cast<int32_t>(k));
      if (attribute.name[0] != 0) {
        EXPECT_EQ(psplit_mesh_find_name(mesh, attribute.name), static_cast<int32_t>(k));
      }
    }
    for (size_t semantic = 0; semantic < seen.size(); ++semantic)
      EXPECT_EQ(psplit_mesh_find_semantic(mesh, static_cast<psplit_semantic>(semantic), seen[semantic]), -1);
    EXPECT_EQ(psplit_mesh_find_name(mesh, "NO_SUCH_NAME"), -1);
  }
}

TEST(CDecode, WholeStreamsGoToShortIndicesAndToWantedAttributesOnly) {
  size_t count = 0;
  for (const DracoStream& stream : small_draco_streams()) {
    SCOPED_TRACE(stream.name);
    const Opened opened = open_bytes(PSPLIT_KIND_DRACO_FILE, stream.bytes);
    if (!is_decoded(opened)) continue;
    const psplit_mesh_info info = info_of(opened.mesh.get());
    const RawMesh whole = decode_file(opened.mesh.get(), 0);
    std::vector<std::array<uint16_t, 3>> faces(info.face_count);
    for (uint32_t wanted = 0; wanted < info.attribute_count; ++wanted) {
      const size_t size = attribute_of(opened.mesh.get(), wanted).value_size;
      std::vector<uint8_t> values(info.point_count * size);
      PrimitiveBuffers out{faces, 2};
      out.attributes.resize(info.attribute_count);
      out.attributes[wanted] = {values, 0};
      const CBuffers buffers(out);
      ASSERT_EQ(psplit_mesh_decode_patch(opened.mesh.get(), 0, &buffers.buffers, nullptr, nullptr), PSPLIT_OK);
      EXPECT_EQ(values, whole.attributes[wanted].point_values);
      for (size_t face = 0; face < faces.size(); ++face)
        for (size_t k = 0; k < 3; ++k) ASSERT_EQ(faces[face][k], whole.faces[face][k]);
      ++count;
    }
  }
  EXPECT_GT(count, 100u);
}

struct Stock {
  std::vector<uint8_t> bytes;
  std::vector<AttributeRequest> requests;
  Mesh mesh;
};
const Stock& stock_sample() {
  static const Stock sample = [] {
    const Mesh& mesh = procedural_meshes().front().mesh;
    StockStream stream = must(encode_stock_stream(mesh, default_codings(mesh, false).codings, 5));
    return Stock{std::move(stream.bytes), std::move(stream.requests), std::move(stream.decoded)};
  }();
  return sample;
}

TEST(CDecode, StockStreamsWithRequestsAreLibdracos) {
  const Stock& stock = stock_sample();
  const Handle<psplit_mesh> mesh = must_open(PSPLIT_KIND_DRACO, stock.bytes, stock.requests);
  const psplit_mesh_info info = info_of(mesh.get());
  ASSERT_EQ(info.point_count, stock.mesh.point_count);
  Buffers buffers(stock.requests, info.point_count, info.face_count, 4, 5);
  const CBuffers out(buffers.out);
  ASSERT_EQ(psplit_mesh_decode(mesh.get(), &out.buffers, nullptr, nullptr), PSPLIT_OK);
  EXPECT_TRUE(same_bits(buffers.mesh(stock.requests, info.point_count), stock.mesh));
}

TEST(CDecode, QuantizationIsThatOfTheStreams) {
  size_t quantized = 0;
  for (const PatchedSample& sample : samples()) {
    SCOPED_TRACE(sample.name);
    const Handle<psplit_mesh> mesh = open_sample(sample);
    const Handle<psplit_mesh> again = open_sample(sample);
    for (uint32_t k = 0; k < sample.requests.size(); ++k) {
      auto found = init<psplit_quantization>(), same = init<psplit_quantization>();
      auto error = init<psplit_error>();
      ASSERT_EQ(psplit_mesh_get_quantization(mesh.get(), k, &found, &error), PSPLIT_OK) << error.text;
      ASSERT_EQ(psplit_mesh_get_quantization(again.get(), k, &same, &error), PSPLIT_OK);
      EXPECT_EQ(found.bits, same.bits);
      quantized += found.bits > 0;
      EXPECT_EQ(found.bits > 0 && found.origin_count > 0, found.range > 0);
      EXPECT_TRUE(found.origin_count == 0 || found.origin_count == attribute_of(mesh.get(), k).components);
    }
  }
  EXPECT_GT(quantized, 10u);
}

TEST(CDecode, ManyAtOnceHaveErrorsOfTheirOwn) {
  const Stock& stock = stock_sample();
  std::vector<Handle<psplit_mesh>> meshes;
  std::vector<std::unique_ptr<Buffers>> memory;
  std::vector<std::unique_ptr<CBuffers>> buffers;
  std::vector<psplit_job> jobs;
  std::vector<psplit_error> errors(samples().size() + 1, init<psplit_error>());
  const auto add = [&](Handle<psplit_mesh> mesh, std::span<const AttributeRequest> requests) {
    const psplit_mesh_info info = info_of(mesh.get());
    memory.push_back(std::make_unique<Buffers>(requests, info.point_count, info.face_count));
    buffers.push_back(std::make_unique<CBuffers>(memory.back()->out));
    jobs.push_back(init<psplit_job>());
    jobs.back().mesh = mesh.get();
    jobs.back().buffers = &buffers.back()->buffers;
    jobs.back().error = &errors[meshes.size()];
    jobs.back().code = -1;
    meshes.push_back(std::move(mesh));
  };
  for (const PatchedSample& sample : samples()) add(open_sample(sample), sample.requests);
  add(must_open(PSPLIT_KIND_DRACO, stock.bytes, stock.requests), stock.requests);
  buffers[1]->buffers.index_size = 3;
  jobs[2].mesh = nullptr;
  auto error = init<psplit_error>();
  EXPECT_EQ(psplit_decode_meshes(jobs.data(), jobs.size(), nullptr, &error), PSPLIT_ERROR_USAGE);
  EXPECT_STREQ(error.text, "indices of 3 bytes");
  for (size_t i = 0; i < jobs.size(); ++i) {
    const bool is_wrong = i == 1 || i == 2;
    EXPECT_EQ(jobs[i].code, is_wrong ? PSPLIT_ERROR_USAGE : PSPLIT_OK) << i;
    EXPECT_EQ(errors[i].code, jobs[i].code);
    if (is_wrong) continue;
    const bool is_stock = i == samples().size();
    const auto& requests = is_stock ? stock.requests : samples()[i].requests;
    const Mesh& expected = is_stock ? stock.mesh : samples()[i].mesh;
    EXPECT_TRUE(same_bits(memory[i]->mesh(requests, expected.point_count), expected)) << i;
  }
  EXPECT_EQ(psplit_decode_meshes(nullptr, 0, nullptr, &error), PSPLIT_OK);
  EXPECT_EQ(psplit_decode_meshes(nullptr, 1, nullptr, &error), PSPLIT_ERROR_USAGE);
}

TEST(CDecode, StopEndsDecoding) {
  const PatchedSample& sample = sample_of_many_patches();
  const Handle<psplit_mesh> mesh = open_sample(sample);
  const psplit_mesh_info info = info_of(mesh.get());
  Buffers buffers(sample.requests, info.point_count, info.face_count);
  const CBuffers out(buffers.out);
  struct Seen {
    Handle<psplit_stop> stop{};
    std::atomic<size_t> done = 0, total = 0;
  } seen;
  psplit_stop* stop = nullptr;
  ASSERT_EQ(psplit_stop_create(&stop, nullptr), PSPLIT_OK);
  seen.stop.reset(stop);
  auto run = init<psplit_run>();
  run.threads = 1;
  run.stop = stop;
  run.user = &seen;
  run.progress = [](void* user, size_t done, size_t total) {
    auto* const to = static_cast<Seen*>(user);
    to->done = done;
    to->total = total;
    if (to->stop) psplit_stop_set(to->stop.get(), 1);
  };
  auto error = init<psplit_error>();
  EXPECT_EQ(psplit_mesh_decode(mesh.get(), &out.buffers, &run, &error), PSPLIT_ERROR_CANCELLED);
  EXPECT_STREQ(error.text, "cancelled");
  EXPECT_GT(seen.done, 0u);
  EXPECT_LT(seen.done, info.patch_count);
  EXPECT_EQ(seen.total, info.patch_count);
  EXPECT_EQ(psplit_mesh_decode_patch(mesh.get(), 0, &out.buffers, &run, &error), PSPLIT_ERROR_CANCELLED);
  const Handle<psplit_mesh> file = must_open(PSPLIT_KIND_DRACO_FILE, stock_sample().bytes);
  Buffers none({}, 0, info_of(file.get()).face_count);
  const CBuffers indices(none.out);
  EXPECT_EQ(psplit_mesh_decode(file.get(), &indices.buffers, &run, &error), PSPLIT_ERROR_CANCELLED);
  psplit_stop_set(stop, 0);
  EXPECT_EQ(psplit_mesh_decode(file.get(), &indices.buffers, &run, &error), PSPLIT_OK);
  run.stop = nullptr;
  EXPECT_EQ(psplit_mesh_decode(mesh.get(), &out.buffers, &run, &error), PSPLIT_OK);
  EXPECT_EQ(seen.done, info.patch_count);
}

// Whole streams and one container, with the buffers of their indices.
struct ManyFiles {
  static constexpr size_t kFiles = 5;
  const Stock& stock = stock_sample();
  const PatchedSample& sample = sample_of_many_patches();
  std::vector<Handle<psplit_mesh>> meshes{};
  std::vector<std::unique_ptr<Buffers>> memory{};
  std::vector<std::unique_ptr<CBuffers>> buffers{};
  std::vector<psplit_job> jobs{};
  size_t steps = 0, last_done = 0;
  psplit_stop* stop = nullptr;

  ManyFiles() {
    for (size_t i = 0; i < kFiles; ++i) add(must_open(PSPLIT_KIND_DRACO_FILE, stock.bytes));
    add(open_sample(sample));
    steps = kFiles + info_of(meshes.back().get()).patch_count;
  }
  void add(Handle<psplit_mesh> mesh) {
    memory.push_back(
        std::make_unique<Buffers>(std::span<const AttributeRequest>(), 0, info_of(mesh.get()).face_count));
    buffers.push_back(std::make_unique<CBuffers>(memory.back()->out));
    jobs.push_back(init<psplit_job>());
    jobs.back().mesh = mesh.get();
    jobs.back().buffers = &buffers.back()->buffers;
    meshes.push_back(std::move(mesh));
  }
  psplit_code decode(int32_t threads) {
    auto run = init<psplit_run>();
    run.threads = threads;
    run.stop = stop;
    run.user = this;
    run.progress = [](void* user, size_t done, size_t total) {
      auto* const files = static_cast<ManyFiles*>(user);
      EXPECT_EQ(total, files->steps);
      files->last_done = done;
      if (files->stop != nullptr && done == 2) psplit_stop_set(files->stop, 1);
    };
    return psplit_decode_meshes(jobs.data(), jobs.size(), &run, nullptr);
  }
};

TEST(CDecode, WholeStreamsAreDecodedBesideContainers) {
  ManyFiles files;
  EXPECT_EQ(files.decode(1), PSPLIT_OK);
  EXPECT_EQ(files.last_done, files.steps);
  for (size_t i = 0; i < files.jobs.size(); ++i) {
    const Mesh& expected = i < ManyFiles::kFiles ? files.stock.mesh : files.sample.mesh;
    EXPECT_EQ(files.memory[i]->mesh({}, expected.point_count).faces, expected.faces);
  }
}

TEST(CDecode, StopEndsDecodingBetweenWholeStreams) {
  ManyFiles files;
  ASSERT_EQ(psplit_stop_create(&files.stop, nullptr), PSPLIT_OK);
  const Handle<psplit_stop> stop(files.stop);
  EXPECT_EQ(files.decode(1), PSPLIT_ERROR_CANCELLED);
  for (size_t i = 0; i < files.jobs.size(); ++i)
    EXPECT_EQ(files.jobs[i].code, i < 2 ? PSPLIT_OK : PSPLIT_ERROR_CANCELLED) << i;
}

TEST(CDecode, AWholeStreamMayBeCopiedAndMayNotBeReplaced) {
  std::vector<uint8_t> bytes = stock_sample().bytes;
  const Handle<psplit_mesh> copy = must_open(PSPLIT_KIND_DRACO_FILE, bytes, {}, PSPLIT_COPY);
  const Handle<psplit_mesh> mesh = must_open(PSPLIT_KIND_DRACO_FILE, bytes);
  const RawMesh expected = decode_file(mesh.get(), 0);
  std::fill(bytes.begin(), bytes.end(), uint8_t{0});
  // One of another size: the caller's arrays have the sizes of the first.
  const auto other = std::ranges::find_if(small_draco_streams(), [&](const DracoStream& stream) {
    if (stream.bytes.size() > bytes.size()) return false;
    const Opened opened = open_bytes(PSPLIT_KIND_DRACO_FILE, stream.bytes);
    return opened.code == PSPLIT_OK && info_of(opened.mesh.get()).face_count != info_of(mesh.get()).face_count;
  });
  ASSERT_NE(other, small_draco_streams().end());
  std::ranges::copy(other->bytes, bytes.begin());
  psplit_code code = PSPLIT_OK;
  decode_file(mesh.get(), 0, code);
  EXPECT_EQ(code, PSPLIT_ERROR_INVALID_INPUT);
  EXPECT_EQ(decode_file(copy.get(), 0), expected);
}

TEST(CDecode, BrokenKdTreesAreErrorsOfDecoding) {
  size_t count = 0;
  for (const DracoStream& cloud : small_draco_clouds()) {
    const Opened whole = open_bytes(PSPLIT_KIND_DRACO_FILE, cloud.bytes);
    if (whole.code != PSPLIT_OK || info_of(whole.mesh.get()).coding != PSPLIT_CODING_CLOUD_KD_TREE) continue;
    if (info_of(whole.mesh.get()).attribute_count == 0) continue;
    SCOPED_TRACE(cloud.name);
    const std::span<const uint8_t> part = std::span(cloud.bytes).first(cloud.bytes.size() - 1);
    const Opened opened = open_bytes(PSPLIT_KIND_DRACO_FILE, part);
    if (opened.code != PSPLIT_OK) continue;  // there was nothing to decode
    psplit_code code = PSPLIT_OK;
    decode_file(opened.mesh.get(), 0, code);
    EXPECT_EQ(code, PSPLIT_ERROR_INVALID_INPUT);
    auto quantization = init<psplit_quantization>();
    EXPECT_EQ(psplit_mesh_get_quantization(opened.mesh.get(), 0, &quantization, nullptr),
              PSPLIT_ERROR_INVALID_INPUT);
    ASSERT_EQ(psplit_mesh_get_quantization(whole.mesh.get(), 0, &quantization, nullptr), PSPLIT_OK);
    EXPECT_EQ(quantization.bits, must(describe_stream(cloud.bytes)).attributes[0].bits);
    ++count;
  }
  EXPECT_GT(count, 20u);
}

TEST(CDecode, OneHandleServesManyThreads) {
  const PatchedSample& sample = sample_of_many_patches();
  const Handle<psplit_mesh> mesh = open_sample(sample);
  const Handle<psplit_pool> pool = make_pool(2);
  std::vector<std::thread> threads;
  std::atomic<int> right = 0;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      const psplit_mesh_info info = info_of(mesh.get());
      Buffers buffers(sample.requests, info.point_count, info.face_count);
      const CBuffers out(buffers.out);
      auto run = init<psplit_run>();
      run.pool = pool.get();
      auto quantization = init<psplit_quantization>();
      const bool is_ok = psplit_mesh_decode(mesh.get(), &out.buffers, &run, nullptr) == PSPLIT_OK &&
                         psplit_mesh_get_quantization(mesh.get(), 0, &quantization, nullptr) == PSPLIT_OK;
      right += is_ok && same_bits(buffers.mesh(sample.requests, info.point_count), sample.mesh);
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(right, 4);
}

TEST(CDecode, ACopyOutlivesTheBytes) {
  const PatchedSample& sample = sample_of_many_patches();
  std::vector<uint8_t> bytes = sample.encoded.pieces[0].bytes;
  const Handle<psplit_mesh> mesh = must_open(PSPLIT_KIND_PATCHES, bytes, sample.requests, PSPLIT_COPY);
  std::fill(bytes.begin(), bytes.end(), uint8_t{0xee});
  bytes = {};
  const psplit_mesh_info info = info_of(mesh.get());
  Buffers buffers(sample.requests, info.point_count, info.face_count);
  const CBuffers out(buffers.out);
  ASSERT_EQ(psplit_mesh_decode(mesh.get(), &out.buffers, nullptr, nullptr), PSPLIT_OK);
  EXPECT_TRUE(same_bits(buffers.mesh(sample.requests, info.point_count), sample.mesh));
}

// Opens damaged bytes, and decodes them if that succeeds. Every outcome but a crash is allowed; the codes equal
// the codes of the C++ interface.
void try_bytes(psplit_kind kind, const std::vector<uint8_t>& bytes,
               std::span<const AttributeRequest> requests) {
  const Opened opened = open_bytes(kind, bytes, requests);
  if (opened.code != PSPLIT_OK) {
    EXPECT_TRUE(opened.code == PSPLIT_ERROR_INVALID_INPUT || opened.code == PSPLIT_ERROR_UNSUPPORTED)
        << opened.code << opened.error.text;
    return;
  }
  const psplit_mesh* const mesh = opened.mesh.get();
  if (kind == PSPLIT_KIND_DRACO_FILE) {
    psplit_code code = PSPLIT_OK;
    decode_file(mesh, 0, code);
    EXPECT_TRUE(code == PSPLIT_OK || code == PSPLIT_ERROR_INVALID_INPUT) << code;
    return;
  }
  const psplit_mesh_info info = info_of(mesh);
  Buffers buffers(requests, info.point_count, info.face_count);
  const CBuffers out(buffers.out);
  auto run = init<psplit_run>();
  run.threads = 1;
  auto error = init<psplit_error>();
  const psplit_code code = psplit_mesh_decode(mesh, &out.buffers, &run, &error);
  EXPECT_TRUE(code == PSPLIT_OK || code == PSPLIT_ERROR_INVALID_INPUT || code == PSPLIT_ERROR_UNSUPPORTED)
      << code << error.text;
  auto quantization = init<psplit_quantization>();
  (void)psplit_mesh_get_quantization(mesh, 0, &quantization, &error);
}

TEST(CDecode, MutantsAreErrors) {
  const PatchedSample& sample = sample_of_many_patches();
  const Stock& stock = stock_sample();
  std::mt19937 random(1);
  const size_t count = fewer_with_sanitizers(500);
  for (size_t i = 0; i < count; ++i) {
    std::vector<uint8_t> container = sample.encoded.pieces[0].bytes, stream = stock.bytes;
    for (std::vector<uint8_t>* bytes : {&container, &stream}) {
      edit(*bytes, random() % (i % 2 == 0 ? 200 : bytes->size()), random);
      if (i % 3 == 0) bytes->resize(random() % bytes->size());
    }
    try_bytes(PSPLIT_KIND_PATCHES, container, sample.requests);
    try_bytes(PSPLIT_KIND_DRACO, stream, stock.requests);
    try_bytes(PSPLIT_KIND_DRACO_FILE, stream, {});
  }
  for (const psplit_kind kind : {PSPLIT_KIND_PATCHES, PSPLIT_KIND_DRACO, PSPLIT_KIND_DRACO_FILE})
    EXPECT_EQ(open_bytes(kind, {}).code, PSPLIT_ERROR_INVALID_INPUT);
}

TEST(CDecode, TruncationsAreErrors) {
  const PatchedSample small = [] {
    const Mesh mesh = make_grid(6, 6);
    return encode_sample("grid", mesh, fine_codings(mesh, 12), {.patch_count = 3}, ThreadPool(1));
  }();
  for_each_truncation(small.encoded.pieces[0].bytes, [&](const std::vector<uint8_t>& bytes) {
    EXPECT_NE(open_bytes(PSPLIT_KIND_PATCHES, bytes, small.requests).code, PSPLIT_OK);
  });
  const PatchContainer container = must(open_container(small.encoded.pieces[0].bytes));
  for_each_truncation(container.streams[0], [&](const std::vector<uint8_t>& bytes) {
    try_bytes(PSPLIT_KIND_DRACO, bytes, small.requests);
    EXPECT_NE(open_bytes(PSPLIT_KIND_DRACO_FILE, bytes).code, PSPLIT_OK);
  });
}

TEST(CDecode, ErrorsNameThePatch) {
  const PatchedSample& sample = sample_of_many_patches();
  const PatchContainer container = must(open_container(sample.encoded.pieces[0].bytes));
  std::vector<uint8_t> bytes = sample.encoded.pieces[0].bytes;
  // The end of the second stream becomes other bytes: its connectivity or values do not decode.
  const auto end = static_cast<size_t>(container.streams[1].data() + container.streams[1].size() -
                                       sample.encoded.pieces[0].bytes.data());
  std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(end - container.streams[1].size() * 9 / 10),
            bytes.begin() + static_cast<std::ptrdiff_t>(end), uint8_t{0xff});
  const Opened opened = open_bytes(PSPLIT_KIND_PATCHES, bytes, sample.requests);
  ASSERT_EQ(opened.code, PSPLIT_OK) << opened.error.text;
  const psplit_mesh_info info = info_of(opened.mesh.get());
  Buffers buffers(sample.requests, info.point_count, info.face_count);
  const CBuffers out(buffers.out);
  auto error = init<psplit_error>();
  EXPECT_EQ(psplit_mesh_decode(opened.mesh.get(), &out.buffers, nullptr, &error), PSPLIT_ERROR_INVALID_INPUT);
  EXPECT_EQ(error.patch, 1);
  EXPECT_EQ(error.mesh, -1);
  EXPECT_EQ(std::string(error.text).substr(0, 9), "patch 1: ");
}

TEST(CDecode, LibdracoDecodesBitstreamsBefore22) {
  const std::vector<uint8_t> stream = older_stream();
  const std::vector<AttributeRequest> requests = {{"_ID", 7, ComponentType::kUint16, 1, false},
                                                  {"POSITION", 5, ComponentType::kFloat32, 3, false}};
  for (const psplit_kind kind : {PSPLIT_KIND_DRACO_FILE, PSPLIT_KIND_DRACO}) {
    const bool is_file = kind == PSPLIT_KIND_DRACO_FILE;
    const Handle<psplit_mesh> mesh = is_file ? must_open(kind, stream) : must_open(kind, stream, requests);
    ASSERT_NE(mesh, nullptr);
    const psplit_mesh_info info = info_of(mesh.get());
    EXPECT_EQ(info.kind, kind);
    EXPECT_EQ(info.coding, is_file ? PSPLIT_CODING_SEQUENTIAL : PSPLIT_CODING_UNKNOWN);
    EXPECT_EQ(info.face_count, 2u);
    EXPECT_EQ(info.point_count, 4u);
    ASSERT_EQ(info.attribute_count, 2u);
    const int32_t position = psplit_mesh_find_semantic(mesh.get(), PSPLIT_POSITION, 0),
                  id = psplit_mesh_find_id(mesh.get(), 7);
    EXPECT_EQ(position, is_file ? 0 : 1);
    ASSERT_EQ(id, 1 - position);
    auto quantization = init<psplit_quantization>();
    EXPECT_EQ(psplit_mesh_get_quantization(mesh.get(), 0, &quantization, nullptr), PSPLIT_OK);
    EXPECT_EQ(quantization.bits, 0);
    uint16_t indices[6] = {}, ids[4 * 3] = {};
    float positions[4 * 3] = {};
    psplit_attribute_buffer attributes[2] = {init<psplit_attribute_buffer>(), init<psplit_attribute_buffer>()};
    attributes[position].data = positions;
    attributes[position].size = sizeof(positions);
    attributes[id].data = ids;
    attributes[id].size = sizeof(ids);
    attributes[id].stride = 3 * sizeof(uint16_t);
    auto buffers = init<psplit_buffers>();
    buffers.index_size = 2;
    buffers.indices = indices;
    buffers.indices_size = sizeof(indices);
    buffers.attributes = attributes;
    buffers.attribute_count = 2;
    psplit_error error = init<psplit_error>();
    for (const bool is_patch : {false, true}) {
      ASSERT_EQ(is_patch ? psplit_mesh_decode_patch(mesh.get(), 0, &buffers, nullptr, &error)
                         : psplit_mesh_decode(mesh.get(), &buffers, nullptr, &error),
                PSPLIT_OK)
          << error.text;
      EXPECT_EQ(std::vector<uint16_t>(std::begin(indices), std::end(indices)),
                (std::vector<uint16_t>{0, 1, 2, 2, 1, 3}));
      EXPECT_EQ(positions[11], 0.5F);
      EXPECT_EQ(ids[0], 9);
      EXPECT_EQ(ids[3], 8);
      EXPECT_EQ(ids[1], 0);
      EXPECT_EQ(ids[9], 6);
    }
    attributes[position].data = nullptr;  // not wanted
    attributes[position].size = 0;
    std::ranges::fill(positions, 0.0F);
    EXPECT_EQ(psplit_mesh_decode(mesh.get(), &buffers, nullptr, &error), PSPLIT_OK);
    EXPECT_EQ(positions[11], 0.0F);
  }
  const std::vector<AttributeRequest> missing = {{"POSITION", 6, ComponentType::kFloat32, 3, false}};
  const Handle<psplit_mesh> wrong = must_open(PSPLIT_KIND_DRACO, stream, missing);
  uint32_t four_bytes[6] = {};
  auto without = init<psplit_buffers>();
  without.index_size = 4;
  without.indices = four_bytes;
  without.indices_size = sizeof(four_bytes);
  EXPECT_EQ(psplit_mesh_decode(wrong.get(), &without, nullptr, nullptr), PSPLIT_OK);  // it is not wanted
  for (size_t size = 0; size < stream.size(); ++size)
    EXPECT_NE(open_bytes(PSPLIT_KIND_DRACO_FILE, std::span(stream).first(size)).code, PSPLIT_OK) << size;
  // The point cloud of the bitstream has no reader.
  std::vector<uint8_t> cloud = stream;
  cloud[7] = 0;
  EXPECT_EQ(open_bytes(PSPLIT_KIND_DRACO_FILE, cloud).code, PSPLIT_ERROR_UNSUPPORTED);
}

}  // namespace
}  // namespace psplit
