// The whole decoder of a device but for the device: every body of its kernels by the emulated warp, in several
// orders, against libdraco.
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "decoder_cuda/host_decoder.h"
#include "encoder/coding/quantization.h"
#include "encoder/draco/draco_backend.h"
#include "src/cpu/cpu_backend.h"
#include "tests/decoder_cuda/emulated_device.h"
#include "tests/decoder_cuda/mutants.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

DecodeBackend backend_of(HostDecoder<EmulatedDevice>& decoder) {
  return {"emulated", [&](std::span<const DecodeTask> tasks, const BuffersFor& buffers_for, const ThreadPool&,
                          const Watch& watch) { return decoder.decode_into(tasks, buffers_for, watch); }};
}

Expected<Mesh> decode(HostDecoder<EmulatedDevice>& decoder, std::span<const uint8_t> container,
                      std::span<const AttributeRequest> requests) {
  return decode_container(backend_of(decoder), container, requests, ThreadPool(1));
}

std::vector<Expected<Mesh>> decode(HostDecoder<EmulatedDevice>& decoder, std::span<const DecodeTask> tasks,
                                   const Progress& progress = {}) {
  return backend_of(decoder).decode(tasks, ThreadPool(1), progress);
}

PatchContainer opened(std::span<const uint8_t> bytes) {
  Expected<PatchContainer> container = open_container(bytes);
  EXPECT_TRUE(container) << container.status().to_string();
  return std::move(*container);
}

TEST(HostDecoder, EqualsLibdracoInEveryOrderOfThreadsAndLanes) {
  const ThreadPool pool(2);
  std::vector<HostDecoder<EmulatedDevice>> decoders;
  for (const LaneOrder& order : kLaneOrders) decoders.emplace_back(EmulatedDevice(order));
  size_t count = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    const std::vector<uint8_t>& container = sample.encoded.container;
    const Expected<Mesh> expected = decode_container(draco_backend(), container, sample.requests, pool);
    ASSERT_TRUE(expected) << expected.status().to_string();
    const Expected<Mesh> decoded = decode(decoders[count++ % decoders.size()], container, sample.requests);
    ASSERT_TRUE(decoded) << decoded.status().to_string();
    EXPECT_TRUE(same_bits(*decoded, *expected));
  }
}

// Where a primitive of a batch is decoded to.
struct Outputs {
  EmulatedDevice::Array<uint32_t> indices;
  std::vector<EmulatedDevice::Array<uint8_t>> values;
};

CudaAttribute attribute_of(const AttributeRequest& request, void* values, size_t stride) {
  return {request.unique_id, request.component_type, request.component_count, values,
          static_cast<uint32_t>(stride)};
}

// The whole container, to outputs that this allocates.
CudaPrimitive primitive_of(const PatchContainer& container, std::span<const AttributeRequest> requests,
                           Outputs& outputs) {
  (void)outputs.indices.reserve(size_t{3} * container.face_count());
  outputs.values.resize(requests.size());
  CudaPrimitive primitive{.container = &container, .indices = outputs.indices.data()};
  for (size_t i = 0; i < requests.size(); ++i) {
    (void)outputs.values[i].reserve(container.point_count() * requests[i].value_bytes());
    primitive.attributes.push_back(
        attribute_of(requests[i], outputs.values[i].data(), requests[i].value_bytes()));
  }
  return primitive;
}

// A grid of so many quads a side and so many attributes beside POSITION, all on grids of 12 bits.
PatchedSample grid_sample(uint32_t side, uint32_t patch_count, uint32_t attribute_count, const ThreadPool& pool,
                          int speed = 5) {
  Mesh mesh = make_grid(side, side);
  for (uint32_t k = 0; k < attribute_count; ++k) {
    std::vector<float> values(mesh.point_count);
    for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i * (k + 1) % 101);
    mesh.attributes.push_back(
        make_attribute("_A" + std::to_string(k), ComponentType::kFloat32, 1, false, values));
  }
  std::vector<AttributeCoding> codings;
  for (const Attribute& attribute : mesh.attributes) codings.push_back(*fit_grid(attribute, 12));
  EncodeOptions options;
  options.patch_count = patch_count;
  options.encode_speed = speed;
  options.verify = false;
  PatchedSample sample{"grid", std::move(*encode_mesh(mesh, codings, options, pool)), {}};
  for (size_t i = 0; i < mesh.attributes.size(); ++i)
    sample.requests.push_back({mesh.attributes[i].semantic, sample.encoded.unique_ids[i],
                               ComponentType::kFloat32, mesh.attributes[i].component_count});
  return sample;
}

// How much memory devices have, for a while.
struct ShortMemory {
  explicit ShortMemory(size_t bytes) { EmulatedDevice::memory() = bytes; }
  ~ShortMemory() { EmulatedDevice::memory() = ~size_t{0}; }
  ShortMemory(const ShortMemory&) = delete;
  ShortMemory& operator=(const ShortMemory&) = delete;
};

void expect_indices(const Outputs& outputs, const PatchedSample& sample) {
  const Expected<Mesh> expected =
      decode_container(cpu_backend(), sample.encoded.container, sample.requests, ThreadPool(1));
  ASSERT_TRUE(expected);
  EXPECT_EQ(std::memcmp(outputs.indices.data(), expected->faces.data(), 12 * expected->faces.size()), 0);
}

TEST(BatchDecoder, TakesManyPrimitivesAtOnce) {
  const ThreadPool pool(2);
  const std::vector<PatchedSample> samples = patched_samples(pool);
  std::vector<PatchContainer> containers;
  for (const PatchedSample& sample : samples) containers.push_back(opened(sample.encoded.container));
  std::vector<Outputs> outputs(samples.size());
  std::vector<CudaPrimitive> primitives;
  for (size_t i = 0; i < samples.size(); ++i)
    primitives.push_back(primitive_of(containers[i], samples[i].requests, outputs[i]));
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  ASSERT_TRUE(decoder.start(primitives).ok());
  const Status status = decoder.finish();
  ASSERT_TRUE(status.ok()) << status.to_string();
  for (size_t i = 0; i < samples.size(); ++i) {
    const Expected<Mesh> expected =
        decode_container(draco_backend(), samples[i].encoded.container, samples[i].requests, pool);
    ASSERT_TRUE(expected);
    EXPECT_EQ(std::memcmp(outputs[i].indices.data(), expected->faces.data(), 12 * expected->faces.size()), 0);
    for (size_t k = 0; k < samples[i].requests.size(); ++k) {
      const Array<std::byte>& values = expected->attributes[k].values;
      EXPECT_EQ(std::memcmp(outputs[i].values[k].data(), values.data(), values.size()), 0) << samples[i].name;
    }
  }
}

TEST(BatchDecoder, WritesIndicesOfTwoBytesAndInterleavedValues) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  uint32_t padding = 3;  // bytes between points that nobody writes to; values need not be aligned
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    padding = padding == 3 ? 4 : 3;
    const PatchContainer input = opened(sample.encoded.container);
    const Expected<Mesh> expected =
        decode_container(draco_backend(), sample.encoded.container, sample.requests, pool);
    ASSERT_TRUE(expected);
    uint32_t stride = padding;
    for (const Attribute& attribute : expected->attributes) stride += static_cast<uint32_t>(attribute.stride());
    std::vector<uint16_t> indices(3 * expected->faces.size());
    std::vector<uint8_t> points(size_t{stride} * expected->point_count, 0x5a);
    CudaPrimitive primitive{.container = &input};
    primitive.indices = indices.data();
    primitive.index_bytes = 2;
    size_t offset = 0;
    for (size_t i = 0; i < sample.requests.size(); offset += expected->attributes[i++].stride())
      primitive.attributes.push_back(attribute_of(sample.requests[i], points.data() + offset, stride));
    ASSERT_TRUE(decoder.start({&primitive, 1}).ok());
    const Status status = decoder.finish();
    if (expected->point_count > 0xffff) {
      EXPECT_EQ(status.code(), StatusCode::kUsage);
      continue;
    }
    ASSERT_TRUE(status.ok()) << status.to_string();
    for (size_t i = 0; i < indices.size(); ++i) ASSERT_EQ(indices[i], expected->faces[i / 3][i % 3]);
    for (size_t point = 0; point < expected->point_count; ++point) {
      const uint8_t* at = points.data() + point * stride;
      for (const Attribute& attribute : expected->attributes) {
        ASSERT_EQ(std::memcmp(at, attribute.values.data() + point * attribute.stride(), attribute.stride()), 0);
        at += attribute.stride();
      }
      ASSERT_TRUE(std::all_of(at, at + padding, [](uint8_t byte) { return byte == 0x5a; }));
    }
  }
}

// Of results and of all else, down to a patch at a time.
TEST(HostDecoder, DecodesInPartsWhereMemoryIsShort) {
  const ThreadPool pool(2);
  const std::vector<PatchedSample> samples = patched_samples(pool);
  std::vector<PatchContainer> containers;
  for (const PatchedSample& sample : samples) containers.push_back(opened(sample.encoded.container));
  std::vector<DecodeTask> tasks;
  for (size_t i = 0; i < samples.size(); ++i) tasks.push_back({&containers[i], samples[i].requests});
  for (const uint64_t limit : {uint64_t{1}, uint64_t{400'000}, uint64_t{4'000'000}}) {
    HostDecoder<EmulatedDevice> decoder{EmulatedDevice({LaneOrder::kDescending}), limit};
    size_t last = 0;
    const std::vector<Expected<Mesh>> decoded = decode(decoder, tasks, [&](size_t done, size_t total) {
      EXPECT_EQ(total, tasks.size());
      EXPECT_GT(done, last);
      last = done;
    });
    EXPECT_EQ(last, tasks.size());
    for (size_t i = 0; i < samples.size(); ++i) {
      ASSERT_TRUE(decoded[i]) << samples[i].name << ": " << decoded[i].status().to_string();
      const Expected<Mesh> expected =
          decode_container(cpu_backend(), samples[i].encoded.container, samples[i].requests, pool);
      EXPECT_TRUE(same_bits(*decoded[i], *expected)) << samples[i].name;
    }
  }
}

// One mesh in a quarter of the memory that it takes at once.
TEST(HostDecoder, TakesNoMoreMemoryThanItMay) {
  const ThreadPool pool(2);
  const PatchedSample sample = grid_sample(100, 40, 0, pool);
  const std::vector<uint8_t>& container = sample.encoded.container;
  const Expected<Mesh> expected = decode_container(cpu_backend(), container, sample.requests, pool);
  ASSERT_TRUE(expected);
  const size_t before = EmulatedDevice::bytes_in_use();
  size_t whole = 0;
  {
    HostDecoder<EmulatedDevice> decoder{EmulatedDevice()};
    const Expected<Mesh> decoded = decode(decoder, container, sample.requests);
    ASSERT_TRUE(decoded && same_bits(*decoded, *expected));
    whole = EmulatedDevice::bytes_in_use() - before;
  }
  // No more than it is told, or than there is.
  const size_t limit = whole / 4;
  const ShortMemory memory(before + limit);
  for (const size_t told : {limit, whole}) {
    HostDecoder<EmulatedDevice> decoder{EmulatedDevice(), told};
    const Expected<Mesh> decoded = decode(decoder, container, sample.requests);
    EXPECT_TRUE(decoded && same_bits(*decoded, *expected)) << decoded.status().to_string();
  }
}

// Whatever was decoded before: many small meshes take memory for other things than a window of a large one.
TEST(HostDecoder, StaysWithinItsMemoryFromBatchToBatch) {
  const ThreadPool pool(2);
  const PatchedSample small = grid_sample(1, 1, 0, pool), large = grid_sample(200, 100, 3, pool);
  constexpr size_t kCount = 1500, kLimit = 2'000'000;
  const PatchContainer small_container = opened(small.encoded.container),
                       large_container = opened(large.encoded.container);
  std::vector<DecodeTask> tasks(2 * kCount + 1, {&small_container, small.requests});
  tasks[kCount] = {&large_container, large.requests};
  const Expected<Mesh> expected =
      decode_container(cpu_backend(), large.encoded.container, large.requests, pool);
  const size_t before = EmulatedDevice::bytes_in_use();
  EmulatedDevice::most_bytes_in_use() = before;
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice(), kLimit};
  const std::vector<Expected<Mesh>> decoded = decode(decoder, tasks);
  for (const Expected<Mesh>& mesh : decoded) ASSERT_TRUE(mesh) << mesh.status().to_string();
  EXPECT_TRUE(same_bits(*decoded[kCount], *expected));
  EXPECT_LE(EmulatedDevice::most_bytes_in_use(), before + kLimit);
}

TEST(HostDecoder, UploadsLargeMeshesOnce) {
  const ThreadPool pool(2);
  const PatchedSample sample = grid_sample(100, 40, 0, pool);
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice(), 200'000};
  EmulatedDevice::work() = {};
  ASSERT_TRUE(decode(decoder, sample.encoded.container, sample.requests));
  // Tables of each window, and patches that it refers to.
  EXPECT_LT(EmulatedDevice::work().uploaded_bytes, 3 * sample.encoded.container.size());
}

TEST(HostDecoder, DownloadsManyResultsAtOnce) {
  const ThreadPool pool(2);
  const PatchedSample sample = grid_sample(4, 1, 2, pool);
  const PatchContainer container = opened(sample.encoded.container);
  const std::vector<DecodeTask> tasks(100, {&container, sample.requests});
  const Expected<Mesh> expected =
      decode_container(cpu_backend(), sample.encoded.container, sample.requests, pool);
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  EmulatedDevice::work() = {};
  for (const Expected<Mesh>& mesh : decode(decoder, tasks)) EXPECT_TRUE(mesh && same_bits(*mesh, *expected));
  EXPECT_LE(EmulatedDevice::work().downloads, 4u);
}

// Others took memory meanwhile: what there is room for is decoded.
TEST(HostDecoder, ShortageIsNoOthersError) {
  const ThreadPool pool(2);
  const PatchedSample small = grid_sample(10, 1, 0, pool), large = grid_sample(100, 1, 0, pool);
  const PatchContainer small_container = opened(small.encoded.container),
                       large_container = opened(large.encoded.container);
  const std::vector<DecodeTask> tasks{{&small_container, small.requests},
                                      {&large_container, large.requests},
                                      {&small_container, small.requests}};
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  const ShortMemory memory(EmulatedDevice::bytes_in_use() + 150'000);
  const std::vector<Expected<Mesh>> decoded = decode(decoder, tasks);
  EXPECT_TRUE(decoded[0]) << decoded[0].status().to_string();
  EXPECT_EQ(decoded[1].status().code(), StatusCode::kRuntimeFailure);
  EXPECT_TRUE(decoded[2]) << decoded[2].status().to_string();
}

// A batch of two, of which the first takes more memory than was foreseen: nobody asked for its attributes, and
// fast streams do not count them in their headers.
class NeedyBatch : public testing::Test {
 protected:
  const ThreadPool pool{2};
  const PatchedSample needy = grid_sample(60, 1, 40, pool, 10), modest = grid_sample(60, 20, 0, pool);
  const PatchContainer needy_input = opened(needy.encoded.container);
  const PatchContainer modest_input = opened(modest.encoded.container);
  Outputs needy_outputs, modest_outputs;
  const CudaPrimitive batch[2]{primitive_of(needy_input, std::span(needy.requests).first(1), needy_outputs),
                               primitive_of(modest_input, modest.requests, modest_outputs)};
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
};

TEST_F(NeedyBatch, IsDecodedAgainForThoseThatNeedMore) {
  size_t launches_at_first = 0;
  for (int time = 0; time < 2; ++time) {
    ASSERT_TRUE(decoder.start(batch).ok());
    launches_at_first = EmulatedDevice::work().launches;
    EmulatedDevice::work() = {};
    const Status status = decoder.finish();
    ASSERT_TRUE(status.ok()) << status.to_string();
    expect_indices(needy_outputs, needy);
    expect_indices(modest_outputs, modest);
  }
  ASSERT_GT(launches_at_first, 0u);
  // One stream in one run each, and the second time there is room for it behind what was uploaded.
  EXPECT_GT(EmulatedDevice::work().launches, 0u);
  EXPECT_LE(EmulatedDevice::work().most_items, LaunchPlan::kMostRuns);
  EXPECT_LT(EmulatedDevice::work().uploaded_bytes, 20'000u);
}

TEST_F(NeedyBatch, OnlyThoseThatNeedMoreFailWhereThereIsNone) {
  ASSERT_TRUE(decoder.start(batch).ok());
  {
    const ShortMemory memory(EmulatedDevice::bytes_in_use());
    EXPECT_EQ(decoder.finish().code(), StatusCode::kRuntimeFailure);
  }
  EXPECT_EQ(decoder.status(0).code(), StatusCode::kRuntimeFailure);
  EXPECT_TRUE(decoder.status(1).ok()) << decoder.status(1).to_string();
  expect_indices(modest_outputs, modest);
  EXPECT_EQ(decoder.finish().code(), StatusCode::kRuntimeFailure);  // as before
}

TEST(BatchDecoder, DecodesInPartsWhereTheDeviceIsSmall) {
  const ThreadPool pool(2);
  const PatchedSample sample = grid_sample(100, 40, 0, pool);
  const PatchContainer input = opened(sample.encoded.container);
  Outputs outputs;
  const CudaPrimitive primitive = primitive_of(input, sample.requests, outputs);
  const size_t before = EmulatedDevice::bytes_in_use();
  size_t whole = 0;
  {
    BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
    ASSERT_TRUE(decoder.start({&primitive, 1}).ok());
    ASSERT_TRUE(decoder.finish().ok());
    whole = EmulatedDevice::bytes_in_use() - before;
  }
  const ShortMemory memory(before + whole / 2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  const Status status = decoder.start({&primitive, 1});
  EXPECT_TRUE(status.ok()) << status.to_string();
  EXPECT_TRUE(decoder.finish().ok());
  expect_indices(outputs, sample);
}

// What none is right for is an error of start, and of finish as often as it is asked.
TEST(BatchDecoder, FailsWhereThereIsNoMemoryAtAll) {
  const ThreadPool pool(2);
  const PatchedSample sample = grid_sample(10, 1, 0, pool);
  const PatchContainer input = opened(sample.encoded.container);
  Outputs outputs;
  const CudaPrimitive primitive = primitive_of(input, sample.requests, outputs);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  {
    const ShortMemory memory(EmulatedDevice::bytes_in_use());
    EXPECT_EQ(decoder.start({&primitive, 1}).code(), StatusCode::kRuntimeFailure);
    EXPECT_EQ(decoder.finish().code(), StatusCode::kRuntimeFailure);
    EXPECT_EQ(decoder.finish().code(), StatusCode::kRuntimeFailure);
    EXPECT_EQ(decoder.point_count(0), 0u);
  }
  ASSERT_TRUE(decoder.start({&primitive, 1}).ok());
  EXPECT_TRUE(decoder.finish().ok());
  EXPECT_TRUE(decoder.finish().ok());
  expect_indices(outputs, sample);
}

// Launches do not grow with the attributes of one stream; what is left is done at the end.
TEST(BatchDecoder, LaunchesNoMoreThanMostStreamsNeed) {
  const ThreadPool pool(2);
  const PatchedSample sample = grid_sample(10, 2, 50, pool);
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  EmulatedDevice::work() = {};
  const Expected<Mesh> decoded = decode(decoder, sample.encoded.container, sample.requests);
  const Expected<Mesh> expected =
      decode_container(cpu_backend(), sample.encoded.container, sample.requests, pool);
  ASSERT_TRUE(decoded) << decoded.status().to_string();
  EXPECT_TRUE(same_bits(*decoded, *expected));
  EXPECT_LE(EmulatedDevice::work().most_items, 2 * LaunchPlan::kMostRuns);
  EXPECT_LE(EmulatedDevice::work().launches, 3 + 2 * LaunchPlan::kMostRounds);
}

TEST(BatchDecoder, GrowsInLeaps) {
  const ThreadPool pool(2);
  const PatchedSample sample = grid_sample(60, 60, 0, pool);
  const PatchContainer input = opened(sample.encoded.container);
  Outputs outputs;
  CudaPrimitive primitive = primitive_of(input, sample.requests, outputs);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  EmulatedDevice::work() = {};
  for (primitive.end = 1; primitive.end <= 60; ++primitive.end) {
    ASSERT_TRUE(decoder.start({&primitive, 1}).ok());
    ASSERT_TRUE(decoder.finish().ok());
  }
  EXPECT_LT(EmulatedDevice::work().reservations, 30u);
}

// Patches [2, 5) in their places of the mesh.
TEST(BatchDecoder, DecodesWindowsOfStitchedMeshes) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice({LaneOrder::kShuffled, 6})};
  size_t count = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    const PatchContainer input = opened(sample.encoded.container);
    const PatchContainer& container = input;
    const Expected<Mesh> expected =
        decode_container(draco_backend(), sample.encoded.container, sample.requests, pool);
    ASSERT_TRUE(expected);
    const auto streams = static_cast<uint32_t>(container.entries.size());
    const uint32_t first = std::min(2u, streams), end = std::min(5u, streams);
    Outputs outputs;
    CudaPrimitive primitive = primitive_of(input, sample.requests, outputs);
    primitive.first = first;
    primitive.end = end;
    ASSERT_TRUE(decoder.start({&primitive, 1}).ok());
    const Status status = decoder.finish();
    ASSERT_TRUE(status.ok()) << status.to_string();
    const uint32_t first_face = container.face_base[first], first_point = container.owned_base[first];
    const uint32_t faces = container.face_base[end] - first_face,
                   points = container.owned_base[end] - first_point;
    count += faces;
    EXPECT_EQ(std::memcmp(outputs.indices.data(), expected->faces.data() + first_face, size_t{12} * faces), 0);
    const auto is_poison = [](const auto* at, const auto* to) {
      return std::all_of(at, to, [](auto value) { return static_cast<uint8_t>(value) == 0xa5; });
    };
    EXPECT_TRUE(
        is_poison(outputs.indices.data() + 3 * faces, outputs.indices.data() + 3 * container.face_count()));
    for (size_t k = 0; k < sample.requests.size(); ++k) {
      const size_t stride = expected->attributes[k].stride();
      const auto* const values = reinterpret_cast<const uint8_t*>(expected->attributes[k].values.data());
      EXPECT_EQ(std::memcmp(outputs.values[k].data(), values + first_point * stride, points * stride), 0);
      EXPECT_TRUE(is_poison(outputs.values[k].data() + points * stride,
                            outputs.values[k].data() + container.point_count() * stride));
    }
  }
  EXPECT_GT(count, 10'000u);
}

// Patches [1, 4) of each mesh as they are, one after the other.
TEST(BatchDecoder, DecodesSomePatchesWithoutStitching) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice({LaneOrder::kShuffled, 5})};
  size_t count = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    const PatchContainer input = opened(sample.encoded.container);
    const PatchContainer* const container = &input;
    constexpr uint32_t kFirst = 1;
    const uint32_t end = std::min<uint32_t>(4, static_cast<uint32_t>(container->entries.size()));
    std::vector<Mesh> expected;
    size_t faces = 0, points = 0;
    for (uint32_t i = kFirst; i < end; ++i) {
      Expected<Mesh> patch = decode_stream(draco_backend(), container->streams[i], sample.requests);
      ASSERT_TRUE(patch);
      patch->faces.resize(container->entries[i].face_count);  // a residue may have more
      faces += patch->faces.size();
      points += patch->point_count;
      expected.push_back(std::move(*patch));
    }
    std::vector<uint32_t> indices(3 * faces);
    std::vector<float> bounds(6 * expected.size());
    std::vector<std::vector<uint8_t>> values;
    CudaPrimitive primitive{.container = &input};
    primitive.indices = indices.data();
    primitive.is_stitched = false;
    primitive.first = kFirst;
    primitive.end = 4;
    for (const AttributeRequest& request : sample.requests) {
      values.emplace_back(points * request.value_bytes());
      primitive.attributes.push_back(attribute_of(request, values.back().data(), request.value_bytes()));
    }
    const bool has_bounds = sample.requests[0].component_type == ComponentType::kFloat32;
    if (has_bounds) primitive.bounds = bounds.data();
    Status status = decoder.start({&primitive, 1});
    ASSERT_TRUE(status.ok()) << status.to_string();
    status = decoder.finish();
    ASSERT_TRUE(status.ok()) << status.to_string();
    size_t first_face = 0, first_point = 0;
    for (size_t n = 0; n < expected.size(); ++n) {
      const Mesh& patch = expected[n];
      for (size_t i = 0; i < 3 * patch.faces.size(); ++i)
        ASSERT_EQ(indices[3 * first_face + i], first_point + patch.faces[i / 3][i % 3]);
      for (size_t k = 0; k < values.size(); ++k) {
        const size_t stride = patch.attributes[k].stride();
        ASSERT_EQ(std::memcmp(values[k].data() + first_point * stride, patch.attributes[k].values.data(),
                              patch.attributes[k].values.size()),
                  0);
      }
      for (size_t k = 0; has_bounds && k < 3; ++k) {
        std::vector<float> along;
        for (size_t point = 0; point < patch.point_count; ++point) {
          float value;
          std::memcpy(&value, values[0].data() + 12 * (first_point + point) + 4 * k, sizeof value);
          along.push_back(value);
        }
        EXPECT_EQ(bounds[6 * n + k], *std::min_element(along.begin(), along.end()));
        EXPECT_EQ(bounds[6 * n + 3 + k], *std::max_element(along.begin(), along.end()));
      }
      first_face += patch.faces.size();
      first_point += patch.point_count;
      ++count;
    }
  }
  EXPECT_GT(count, 50u);
}

// Streams for themselves, all of all meshes in one call, as stock Draco has them: nobody says how many points.
TEST(HostDecoder, TakesStockStreams) {
  const ThreadPool pool(2);
  const std::vector<PatchedSample> samples = patched_samples(pool);
  std::vector<PatchContainer> streams;
  std::vector<std::span<const AttributeRequest>> requests;
  for (const PatchedSample& sample : samples)
    for (const std::span<const uint8_t> stream : opened(sample.encoded.container).streams) {
      streams.push_back(open_stream(stream));
      requests.push_back(sample.requests);
    }
  std::vector<DecodeTask> tasks;
  for (size_t i = 0; i < streams.size(); ++i) tasks.push_back({&streams[i], requests[i]});
  for (const uint64_t limit : {uint64_t{0}, uint64_t{1'000'000}}) {
    HostDecoder<EmulatedDevice> decoder{EmulatedDevice(), limit};
    const std::vector<Expected<Mesh>> decoded = decode(decoder, tasks);
    for (size_t i = 0; i < tasks.size(); ++i) {
      const Expected<Mesh> expected = decode_stream(draco_backend(), streams[i].bytes, requests[i]);
      ASSERT_TRUE(expected && decoded[i]) << decoded[i].status().to_string();
      EXPECT_TRUE(same_bits(*decoded[i], *expected));
    }
  }
}

// A stream in less room than its points take is refused, and writes nothing behind it.
TEST(BatchDecoder, TakesNoMoreRoomThanThereIs) {
  const ThreadPool pool(2);
  const PatchedSample sample = patched_samples(pool).front();
  const std::span<const uint8_t> stream = open_container(sample.encoded.container)->streams[0];
  const Expected<Mesh> expected = decode_stream(draco_backend(), stream, sample.requests);
  ASSERT_TRUE(expected);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  for (const uint32_t less : {0u, 1u}) {
    const PatchContainer input = open_stream(stream, expected->point_count - less);
    Outputs outputs;
    CudaPrimitive primitive = primitive_of(input, sample.requests, outputs);
    ASSERT_TRUE(decoder.start({&primitive, 1}).ok());
    EXPECT_EQ(decoder.finish().code(), less == 0 ? StatusCode::kOk : StatusCode::kInvalidInput);
    if (less == 0) {
      EXPECT_EQ(decoder.point_count(0), expected->point_count);
    }
  }
}

// Bounds are those of points that there are, not of what there is room for.
TEST(BatchDecoder, BoundsStockStreams) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  size_t count = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    const std::span<const uint8_t> stream = open_container(sample.encoded.container)->streams[0];
    const PatchContainer input = open_stream(stream);
    const Expected<Mesh> expected = decode_stream(draco_backend(), stream, sample.requests);
    ASSERT_TRUE(expected);
    if (sample.requests[0].component_type != ComponentType::kFloat32 || expected->point_count == 0) continue;
    if (input.point_count() > expected->point_count) ++count;
    Outputs outputs;
    float bounds[6];
    CudaPrimitive primitive = primitive_of(input, sample.requests, outputs);
    primitive.is_stitched = false;
    primitive.bounds = bounds;
    std::memset(outputs.values[0].data(), 0x7f, outputs.values[0].size());
    ASSERT_TRUE(decoder.start({&primitive, 1}).ok());
    ASSERT_TRUE(decoder.finish().ok());
    for (uint32_t k = 0; k < 3; ++k) {
      std::vector<float> along(expected->point_count);
      for (size_t i = 0; i < along.size(); ++i)
        std::memcpy(&along[i], expected->attributes[0].values.data() + 12 * i + 4 * k, sizeof along[i]);
      EXPECT_EQ(bounds[k], *std::min_element(along.begin(), along.end())) << sample.name;
      EXPECT_EQ(bounds[3 + k], *std::max_element(along.begin(), along.end())) << sample.name;
    }
  }
  EXPECT_GT(count, 5u);
}

// What is on the device already is read there.
TEST(BatchDecoder, TakesContainersOnTheDevice) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  const PatchedSample sample = patched_samples(pool).front();
  std::vector<uint8_t> on_device = sample.encoded.container;
  const PatchContainer input = opened(sample.encoded.container);
  const Expected<Mesh> expected =
      decode_container(cpu_backend(), sample.encoded.container, sample.requests, pool);
  Outputs outputs;
  CudaPrimitive primitive = primitive_of(input, sample.requests, outputs);
  primitive.device_bytes = on_device.data();
  ASSERT_TRUE(decoder.start({&primitive, 1}).ok());
  ASSERT_TRUE(decoder.finish().ok());
  EXPECT_EQ(std::memcmp(outputs.indices.data(), expected->faces.data(), 12 * expected->faces.size()), 0);
  // And nowhere else.
  std::fill(on_device.begin(), on_device.end(), uint8_t{0});
  ASSERT_TRUE(decoder.start({&primitive, 1}).ok());
  EXPECT_EQ(decoder.finish().code(), StatusCode::kInvalidInput);
}

// What places on grids stand for is what floats are decoded to, bit for bit.
TEST(BatchDecoder, WritesPlacesOnGrids) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  size_t count = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    const PatchContainer input = opened(sample.encoded.container);
    const Expected<Mesh> expected =
        decode_container(cpu_backend(), sample.encoded.container, sample.requests, pool);
    ASSERT_TRUE(expected);
    for (size_t i = 0; i < sample.requests.size(); ++i) {
      const AttributeRequest& request = sample.requests[i];
      if (request.component_type != ComponentType::kFloat32) continue;
      const uint32_t components = request.component_count, points = expected->point_count;
      std::vector<uint32_t> indices(3 * expected->faces.size());
      std::vector<uint16_t> places(size_t{components} * points);
      std::vector<float> grid(components + 1);
      CudaPrimitive primitive{.container = &input};
      primitive.indices = indices.data();
      primitive.attributes = {{request.unique_id, ComponentType::kUint16, request.component_count,
                               places.data(), 2 * components, grid.data()}};
      ASSERT_TRUE(decoder.start({&primitive, 1}).ok());
      const Status status = decoder.finish();
      if (!status.ok()) {  // exact floats, and normals, have no grid
        EXPECT_EQ(status.code(), StatusCode::kUnsupported);
        continue;
      }
      ++count;
      for (size_t at = 0; at < places.size(); ++at) {
        float value;
        std::memcpy(&value, expected->attributes[i].values.data() + 4 * at, sizeof value);
        ASSERT_EQ(static_cast<float>(places[at]) * grid[components] + grid[at % components], value);
      }
    }
  }
  EXPECT_GT(count, 20u);
}

// Places of one array are on one grid, or they are refused.
TEST(BatchDecoder, RefusesPlacesOnSeveralGrids) {
  const ThreadPool pool(2);
  const auto encoded_on = [&](float size) {
    Mesh mesh = make_mesh({0, 0, 0, size, 0, 0, 0, size, 0}, {{0, 1, 2}});
    const std::vector<AttributeCoding> codings{*fit_grid(mesh.attributes[0], 12)};
    return std::move(*encode_mesh(mesh, codings, {}, pool));
  };
  const EncodedMesh small = encoded_on(1), large = encoded_on(2);
  for (const EncodedMesh* const second : {&small, &large}) {
    std::vector<StreamEntry> entries;
    std::vector<std::vector<uint8_t>> streams;
    for (const EncodedMesh* const mesh : {&small, second}) {
      const Expected<PatchContainer> one = open_container(mesh->container);
      ASSERT_TRUE(one && one->entries.size() == 1 && one->entries[0].stitch_bytes == 0);
      entries.push_back(one->entries[0]);
      streams.emplace_back(one->streams[0].begin(), one->streams[0].end());
    }
    const std::vector<uint8_t> container =
        write_container(entries, false, std::vector<std::vector<uint8_t>>(2), streams);
    const PatchContainer input = opened(container);
    std::vector<uint32_t> indices(6);
    std::vector<uint16_t> places(18);
    std::vector<float> grid(4);
    CudaPrimitive primitive{.container = &input};
    primitive.indices = indices.data();
    primitive.attributes = {{small.unique_ids[0], ComponentType::kUint16, 3, places.data(), 6, grid.data()}};
    BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
    ASSERT_TRUE(decoder.start({&primitive, 1}).ok());
    const Status status = decoder.finish();
    EXPECT_EQ(status.code(), second == &small ? StatusCode::kOk : StatusCode::kInvalidInput);
    EXPECT_EQ(status.place().patch, second == &small ? -1 : 1);
  }
}

// One attribute of several: the others take memory as well.
TEST(BatchDecoder, DecodesSomeAttributesOnly) {
  const ThreadPool pool(2);
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  size_t count = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    if (sample.requests.size() < 2) continue;
    ++count;
    const std::vector<AttributeRequest> first{sample.requests.front()};
    const Expected<Mesh> expected = decode_container(cpu_backend(), sample.encoded.container, first, pool);
    const Expected<Mesh> decoded = decode(decoder, sample.encoded.container, first);
    ASSERT_TRUE(decoded) << sample.name << ": " << decoded.status().to_string();
    EXPECT_TRUE(same_bits(*decoded, *expected)) << sample.name;
  }
  EXPECT_GT(count, 10u);
}

// And decodes the rest of the batch.
TEST(BatchDecoder, RefusesWhatCannotBeAskedFor) {
  const ThreadPool pool(2);
  const PatchedSample sample = patched_samples(pool).front();
  const PatchContainer input = opened(sample.encoded.container);
  const Expected<Mesh> expected =
      decode_container(cpu_backend(), sample.encoded.container, sample.requests, pool);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  Outputs outputs, refused_outputs;
  const CudaPrimitive good = primitive_of(input, sample.requests, outputs);
  const auto refused = [&](auto change) {
    CudaPrimitive bad = primitive_of(input, sample.requests, refused_outputs);
    change(bad);
    const CudaPrimitive batch[] = {bad, good};
    EXPECT_TRUE(decoder.start(batch).ok());
    const Status status = decoder.finish();
    EXPECT_EQ(status.place().primitive, 0);
    EXPECT_EQ(decoder.status(0).code(), status.code());
    EXPECT_EQ(decoder.point_count(0), 0u);
    EXPECT_TRUE(decoder.status(1).ok());
    EXPECT_EQ(std::memcmp(outputs.indices.data(), expected->faces.data(), 12 * expected->faces.size()), 0);
    std::memset(outputs.indices.data(), 0, 12 * expected->faces.size());
    return status.code();
  };
  float bounds[6];
  const auto off_by_one = [](auto* at) {
    return reinterpret_cast<decltype(at)>(reinterpret_cast<uintptr_t>(at) + 1);
  };
  EXPECT_EQ(refused([](CudaPrimitive& bad) { bad.indices = nullptr; }), StatusCode::kUsage);
  EXPECT_EQ(refused([&](CudaPrimitive& bad) { bad.indices = off_by_one(bad.indices); }), StatusCode::kUsage);
  EXPECT_EQ(refused([](CudaPrimitive& bad) { bad.attributes[0].values = nullptr; }), StatusCode::kUsage);
  EXPECT_EQ(refused([&](CudaPrimitive& bad) { bad.attributes[0].grid = off_by_one(bounds); }),
            StatusCode::kUsage);
  EXPECT_EQ(refused([&](CudaPrimitive& bad) { bad.is_stitched = false, bad.bounds = off_by_one(bounds); }),
            StatusCode::kUsage);
  EXPECT_EQ(refused([&](CudaPrimitive& bad) {
              bad.is_stitched = false, bad.bounds = bounds,
              bad.attributes[0].values = off_by_one(bad.attributes[0].values);
            }),
            StatusCode::kUsage);
  EXPECT_EQ(refused([](CudaPrimitive& bad) { bad.index_bytes = 3; }), StatusCode::kUsage);
  EXPECT_EQ(refused([](CudaPrimitive& bad) { bad.first = 3, bad.end = 2; }), StatusCode::kUsage);
  EXPECT_EQ(refused([](CudaPrimitive& bad) { bad.is_stitched = false, bad.first = 3, bad.end = 2; }),
            StatusCode::kUsage);
  EXPECT_EQ(refused([&](CudaPrimitive& bad) { bad.bounds = bounds; }), StatusCode::kUsage);
  EXPECT_EQ(refused([&](CudaPrimitive& bad) {
              bad.is_stitched = false, bad.bounds = bounds, bad.attributes[0].component_count = 2;
            }),
            StatusCode::kUsage);
  EXPECT_EQ(refused([](CudaPrimitive& bad) { bad.attributes[0].stride = 11; }), StatusCode::kUsage);
  EXPECT_EQ(refused([](CudaPrimitive& bad) { bad.attributes[0].component_type = ComponentType::kInt16; }),
            StatusCode::kUnsupported);
  ASSERT_TRUE(decoder.start({}).ok());
  EXPECT_TRUE(decoder.finish().ok());  // of nothing
  ASSERT_TRUE(decoder.start({&good, 1}).ok());
  EXPECT_TRUE(decoder.finish().ok());
}

// The patch that is broken is named; what the others own comes out right, and no index is out of range.
TEST(BatchDecoder, BrokenPatchesHarmNoOther) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice({LaneOrder::kShuffled, 3})};
  std::mt19937 random(1);
  size_t refused = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    const Expected<PatchContainer> whole = open_container(sample.encoded.container);
    ASSERT_TRUE(whole);
    if (whole->patch_count() < 3) continue;
    const Expected<Mesh> expected =
        decode_container(draco_backend(), sample.encoded.container, sample.requests, pool);
    ASSERT_TRUE(expected);
    const uint32_t broken = static_cast<uint32_t>(random()) % whole->patch_count();
    std::vector<uint8_t> bytes = sample.encoded.container;
    const auto stream_at = static_cast<size_t>(whole->streams[broken].data() - sample.encoded.container.data());
    // Behind the header, which the host reads.
    for (size_t at = whole->streams[broken].size() / 3; at < whole->streams[broken].size(); ++at)
      bytes[stream_at + at] = static_cast<uint8_t>(random());
    const PatchContainer input = opened(bytes);
    const PatchContainer* const container = &input;
    Outputs outputs;
    const CudaPrimitive primitive = primitive_of(input, sample.requests, outputs);
    ASSERT_TRUE(decoder.start({&primitive, 1}).ok());
    const Status status = decoder.finish();
    if (status.ok()) continue;
    ++refused;
    EXPECT_EQ(status.place().patch, broken) << status.to_string();
    for (size_t i = 0; i < size_t{3} * container->face_count(); ++i)
      ASSERT_LT(outputs.indices.data()[i], expected->point_count);
    for (uint32_t patch = 0; patch < container->entries.size(); ++patch) {
      if (patch == broken) continue;
      for (size_t k = 0; k < sample.requests.size(); ++k) {
        const size_t stride = expected->attributes[k].stride(), first = container->owned_base[patch] * stride;
        EXPECT_EQ(std::memcmp(outputs.values[k].data() + first, expected->attributes[k].values.data() + first,
                              container->owned_base[patch + 1] * stride - first),
                  0)
            << "patch " << patch;
      }
    }
  }
  EXPECT_GT(refused, 10u);
}

TEST(HostDecoder, TakesAndRefusesMutantsAsTheCpuDoes) {
  HostDecoder<EmulatedDevice> decoder{EmulatedDevice({LaneOrder::kShuffled, 4})};
  expect_mutants_as_on_cpu([&](std::span<const uint8_t> bytes, std::span<const AttributeRequest> requests) {
    return decode(decoder, bytes, requests);
  });
}

}  // namespace
}  // namespace psplit
