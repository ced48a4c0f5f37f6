// The kernel bodies and the batches that launch them, on the emulated warp in several orders, against libdraco.
#include "decoder_cuda/batch_decoder.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <random>
#include <tuple>

#include "psplit/encode.h"
#include "tests/decoder_cuda/device_samples.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/patched_samples.h"

namespace psplit {
namespace {

// Most tests decode containers of at most this size; HostDecoder.EqualsLibdraco... decodes all.
constexpr size_t kMostBytes = 20'000;

// Memory for the results of one primitive.
struct Outputs {
  EmulatedDevice::Array<uint32_t> indices;
  std::vector<EmulatedDevice::Array<uint8_t>> values;
};

CudaAttribute attribute_of(const AttributeRequest& request, void* values, size_t stride) {
  return {request.unique_id, request.component_type, request.component_count, values,
          static_cast<uint32_t>(stride)};
}

// A primitive for the whole container. Allocates its outputs.
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

// A sample with memory for its results.
struct Loaded {
  explicit Loaded(const PatchedSample& of) : Loaded(of, of.requests) {}
  Loaded(const PatchedSample& of, std::span<const AttributeRequest> requests)
      : sample(of),
        input(opened(of.encoded.pieces[0].bytes)),
        primitive(primitive_of(input, requests, outputs)) {}
  Loaded(const Loaded&) = delete;
  Loaded& operator=(const Loaded&) = delete;

  void expect_indices() const {
    EXPECT_EQ(std::memcmp(outputs.indices.data(), sample.mesh.faces.data(), 12 * sample.mesh.faces.size()), 0);
  }

  const PatchedSample& sample;
  const PatchContainer input;
  Outputs outputs;
  CudaPrimitive primitive;
};

Status decode(BatchDecoder<EmulatedDevice>& decoder, const CudaPrimitive& primitive) {
  must(decoder.start({&primitive, 1}));
  return decoder.finish();
}

// The least and the most of the positions.
std::array<float, 6> bounds_of(const void* positions, size_t count) {
  std::array<float, 6> bounds;
  for (size_t k = 0; k < 3; ++k) {
    std::vector<float> along(count);
    for (size_t i = 0; i < count; ++i)
      std::memcpy(&along[i], static_cast<const uint8_t*>(positions) + 12 * i + 4 * k, sizeof along[i]);
    bounds[k] = *std::ranges::min_element(along);
    bounds[3 + k] = *std::ranges::max_element(along);
  }
  return bounds;
}

TEST(BatchDecoder, WritesIndicesOfTwoBytesAndInterleavedValues) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  uint32_t padding = 3;  // bytes between points, which stay untouched; values need not be aligned
  const auto expect_decoded = [&](const PatchedSample& sample) {
    SCOPED_TRACE(sample.name);
    padding = padding == 3 ? 4 : 3;
    const PatchContainer input = opened(sample.encoded.pieces[0].bytes);
    const Mesh* const expected = &sample.mesh;
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
    const Status status = decode(decoder, primitive);
    if (expected->point_count > 0xffff) {
      EXPECT_EQ(status.code(), StatusCode::kUsage);
      return;
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
  };
  for (const PatchedSample& sample : all_samples(pool))
    if (sample.encoded.pieces[0].bytes.size() <= kMostBytes) expect_decoded(sample);
  for (const PatchedSample& sample : large_samples(pool)) expect_decoded(sample);
}

// A batch of two. The first takes more memory than was planned: it has attributes that are not requested, and
// fast streams do not count these in their headers.
class NeedyBatch : public testing::Test {
 protected:
  const ThreadPool pool{2};
  const PatchedSample samples[2]{grid_sample(60, 1, 40, pool, 10), grid_sample(60, 20, 0, pool)};
  const Loaded needy{samples[0], std::span(samples[0].requests).first(1)}, modest{samples[1]};
  const CudaPrimitive batch[2]{needy.primitive, modest.primitive};
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
};

TEST_F(NeedyBatch, IsDecodedAgainForThoseThatNeedMore) {
  size_t launches_at_first = 0;
  for (int time = 0; time < 2; ++time) {
    ASSERT_TRUE(decoder.start(batch).ok());
    launches_at_first = EmulatedDevice::work().launches;
    EmulatedDevice::work() = {};
    must(decoder.finish());
    needy.expect_indices();
    modest.expect_indices();
  }
  ASSERT_GT(launches_at_first, 0u);
  // Only the needy stream is decoded again. The second batch has room for it, so nothing is uploaded again.
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
  modest.expect_indices();
  EXPECT_EQ(decoder.finish().code(), StatusCode::kRuntimeFailure);  // as before
}

// A batch that is ready decodes again and again: nothing is reserved, and tables are not uploaded again.
TEST(PreparedBatch, DecodesAsOftenAsItIsLaunched) {
  const ThreadPool pool(2);
  EmulatedDevice device({LaneOrder::kShuffled, 3});
  size_t count = 0;
  for (const PatchedSample& sample : all_samples(pool)) {
    SCOPED_TRACE(sample.name);
    if (++count % 4 != 0) continue;
    const Loaded loaded(sample);
    PreparedBatch<EmulatedDevice> batch;
    ASSERT_TRUE(batch.make({&loaded.primitive, 1}, BatchPlan::Gather::kAllPieces)[0].ok());
    EmulatedDevice::Array<uint8_t> memory;
    ASSERT_TRUE(memory.reserve(batch.arrange(~uint64_t{0})).ok());
    ASSERT_TRUE(batch.write(memory.data(), true).ok());
    ASSERT_TRUE(batch.upload(device).ok());
    EmulatedDevice::work() = {};
    for (int time = 0; time < 3; ++time) {
      std::fill_n(static_cast<uint32_t*>(loaded.primitive.indices), 3 * sample.mesh.faces.size(), 0xa5a5a5a5u);
      ASSERT_TRUE(batch.launch(device).ok());
      StreamResults results(loaded.input.entries.size());
      batch.take_results(results);
      for (const core::Fault fault : results.faults) EXPECT_EQ(fault, core::Fault::kNone);
      loaded.expect_indices();
    }
    EXPECT_EQ(EmulatedDevice::work().uploaded_bytes, 0u);
    EXPECT_EQ(EmulatedDevice::work().reservations, 0u);
  }
  EXPECT_GT(count, 8u);
}

// The number of threads changes nothing in a plan of thousands of streams.
TEST(BatchPlan, IsTheSameWithAnyNumberOfThreads) {
  const ThreadPool threads(3);
  const PatchedSample sample = grid_sample(100, 5000, 0, threads);
  Loaded loaded(sample);
  ASSERT_GT(loaded.input.entries.size(), 4096u);
  for (const bool is_stitched : {true, false}) {
    loaded.primitive.is_stitched = is_stitched;
    const CudaPrimitive twice[2]{loaded.primitive, loaded.primitive};
    BatchPlan one, many;
    ASSERT_TRUE(one.make(twice, BatchPlan::Gather::kAllPieces)[0].ok());
    ASSERT_TRUE(many.make(twice, BatchPlan::Gather::kAllPieces, &threads)[0].ok());
    one.arrange(uint64_t{50} << 20);
    many.arrange(uint64_t{50} << 20);
    EXPECT_GT(one.parts().size(), 1u);
    EXPECT_EQ(one.parts().size(), many.parts().size());
    EXPECT_EQ(one.workspace_bytes(), many.workspace_bytes());
    EXPECT_EQ(one.walk_points(), many.walk_points());
    EXPECT_EQ(one.piece_bytes(), many.piece_bytes());
    EXPECT_EQ(one.narrow().streams, many.narrow().streams);
    EXPECT_EQ(one.narrow().draco.rounds, many.narrow().draco.rounds);
    EXPECT_EQ(one.narrow().draco.runs, many.narrow().draco.runs);
    EXPECT_EQ(one.narrow().draco.chains, many.narrow().draco.chains);
    ASSERT_EQ(one.streams().size(), many.streams().size());
    const auto places = [](const StreamTask& task) {
      return std::tuple(task.stream_at, task.stitch_at, task.workspace_at, task.workspace_bytes, task.walk_at,
                        task.primitive, task.number, task.face_base, task.owned_base, task.owned_end, task.use,
                        task.has_walk, task.face_count, task.point_count, task.stream_bytes);
    };
    for (size_t i = 0; i < one.streams().size(); ++i)
      ASSERT_EQ(places(one.streams()[i]), places(many.streams()[i])) << i;
  }
}

// Without a second attempt, a stream that needs more memory is an error of its primitive alone.
TEST_F(NeedyBatch, HasAFaultForEachThatNeedsMore) {
  EmulatedDevice device;
  PreparedBatch<EmulatedDevice> prepared;
  std::vector<Status> statuses = prepared.make(batch, BatchPlan::Gather::kAllPieces);
  EmulatedDevice::Array<uint8_t> memory;
  ASSERT_TRUE(memory.reserve(prepared.arrange(~uint64_t{0})).ok());
  ASSERT_TRUE(prepared.write(memory.data(), true).ok());
  ASSERT_TRUE(prepared.upload(device).ok());
  ASSERT_TRUE(prepared.launch(device).ok());
  StreamResults results(prepared.plan().streams().size());
  prepared.take_results(results);
  prepared.plan().add_faults(results.faults, runtime_failure("more memory"), statuses);
  EXPECT_EQ(statuses[0].message(), "more memory");
  EXPECT_EQ(statuses[0].place().primitive, 0);
  EXPECT_TRUE(statuses[1].ok()) << statuses[1].to_string();
  modest.expect_indices();
}

TEST(BatchDecoder, DecodesInPartsWhereTheDeviceIsSmall) {
  const ThreadPool pool(2);
  const PatchedSample sample = grid_sample(100, 40, 0, pool);
  const Loaded loaded(sample);
  const size_t before = EmulatedDevice::bytes_in_use();
  size_t whole = 0;
  {
    BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
    must(decode(decoder, loaded.primitive));
    whole = EmulatedDevice::bytes_in_use() - before;
  }
  const ShortMemory memory(before + whole / 2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  must(decode(decoder, loaded.primitive));
  loaded.expect_indices();
}

// Without any memory, start fails, and so does each finish.
TEST(BatchDecoder, FailsWhereThereIsNoMemoryAtAll) {
  const ThreadPool pool(2);
  const PatchedSample sample = grid_sample(10, 1, 0, pool);
  const Loaded loaded(sample);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  {
    const ShortMemory memory(EmulatedDevice::bytes_in_use());
    EXPECT_EQ(decoder.start({&loaded.primitive, 1}).code(), StatusCode::kRuntimeFailure);
    EXPECT_EQ(decoder.finish().code(), StatusCode::kRuntimeFailure);
    EXPECT_EQ(decoder.finish().code(), StatusCode::kRuntimeFailure);
    EXPECT_EQ(decoder.point_count(0), 0u);
  }
  must(decode(decoder, loaded.primitive));
  EXPECT_TRUE(decoder.finish().ok());
  loaded.expect_indices();
}

TEST(BatchDecoder, GrowsInLeaps) {
  const ThreadPool pool(2);
  const PatchedSample sample = grid_sample(60, 60, 0, pool);
  Loaded loaded(sample);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  EmulatedDevice::work() = {};
  for (uint32_t end = 1; end <= 60; ++end) {
    loaded.primitive.end = end;
    must(decode(decoder, loaded.primitive));
  }
  EXPECT_LT(EmulatedDevice::work().reservations, 30u);
}

// Patches [2, 5) are written to their window of the mesh.
TEST(BatchDecoder, DecodesWindowsOfStitchedMeshes) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice({LaneOrder::kShuffled, 6})};
  size_t count = 0;
  for (const PatchedSample& sample : all_samples(pool)) {
    SCOPED_TRACE(sample.name);
    if (sample.encoded.pieces[0].bytes.size() > kMostBytes) continue;
    Loaded loaded(sample);
    const PatchContainer& container = loaded.input;
    const Outputs& outputs = loaded.outputs;
    const Mesh& expected = sample.mesh;
    const auto streams = static_cast<uint32_t>(container.entries.size());
    const uint32_t first = std::min(2u, streams), end = std::min(5u, streams);
    loaded.primitive.first = first;
    loaded.primitive.end = end;
    must(decode(decoder, loaded.primitive));
    const uint32_t first_face = container.face_base[first], first_point = container.owned_base[first];
    const uint32_t faces = container.face_base[end] - first_face,
                   points = container.owned_base[end] - first_point;
    count += faces;
    EXPECT_EQ(std::memcmp(outputs.indices.data(), expected.faces.data() + first_face, size_t{12} * faces), 0);
    const auto is_poison = [](const auto* at, const auto* to) {
      return std::all_of(at, to, [](auto value) { return static_cast<uint8_t>(value) == 0xa5; });
    };
    EXPECT_TRUE(
        is_poison(outputs.indices.data() + 3 * faces, outputs.indices.data() + 3 * container.face_count()));
    for (size_t k = 0; k < sample.requests.size(); ++k) {
      const size_t stride = expected.attributes[k].stride();
      const auto* const values = reinterpret_cast<const uint8_t*>(expected.attributes[k].values.data());
      EXPECT_EQ(std::memcmp(outputs.values[k].data(), values + first_point * stride, points * stride), 0);
      EXPECT_TRUE(is_poison(outputs.values[k].data() + points * stride,
                            outputs.values[k].data() + container.point_count() * stride));
    }
  }
  EXPECT_GT(count, 10'000u);
}

// Patches [1, 4) of each mesh are written one after the other, with all their points.
TEST(BatchDecoder, DecodesSomePatchesWithoutStitching) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice({LaneOrder::kShuffled, 5})};
  size_t count = 0;
  for (const PatchedSample& sample : all_samples(pool)) {
    SCOPED_TRACE(sample.name);
    if (sample.encoded.pieces[0].bytes.size() > kMostBytes) continue;
    const PatchContainer container = opened(sample.encoded.pieces[0].bytes);
    constexpr uint32_t kFirst = 1;
    const uint32_t end = std::min<uint32_t>(4, static_cast<uint32_t>(container.entries.size()));
    std::vector<Mesh> expected;
    size_t faces = 0, points = 0;
    for (uint32_t i = kFirst; i < end; ++i) {
      Mesh patch = must(draco_backend().decode(container.alone(i), sample.requests, pool));
      patch.faces.resize(container.entries[i].face_count);  // a residue may have more
      faces += patch.faces.size();
      points += patch.point_count;
      expected.push_back(std::move(patch));
    }
    std::vector<uint32_t> indices(3 * faces);
    std::vector<float> bounds(6 * expected.size());
    std::vector<std::vector<uint8_t>> values;
    CudaPrimitive primitive{.container = &container};
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
    must(decode(decoder, primitive));
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
      if (has_bounds) {
        const auto expected_bounds = bounds_of(values[0].data() + 12 * first_point, patch.point_count);
        EXPECT_TRUE(std::ranges::equal(std::span(bounds).subspan(6 * n, 6), expected_bounds));
      }
      first_face += patch.faces.size();
      first_point += patch.point_count;
      ++count;
    }
  }
  EXPECT_GT(count, 50u);
}

// A stream with more points than there is room for is refused, and writes nothing outside of the buffers.
TEST(BatchDecoder, TakesNoMoreRoomThanThereIs) {
  const ThreadPool pool(2);
  const PatchedSample& sample = patched_samples(pool).front();
  const std::span<const uint8_t> stream = open_container(sample.encoded.pieces[0].bytes)->streams[0];
  const Mesh expected = must(decode_stream(draco_backend(), stream, sample.requests));
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  for (const uint32_t less : {0u, 1u}) {
    const PatchContainer input = open_stream(stream, expected.point_count - less);
    Outputs outputs;
    CudaPrimitive primitive = primitive_of(input, sample.requests, outputs);
    EXPECT_EQ(decode(decoder, primitive).code(), less == 0 ? StatusCode::kOk : StatusCode::kInvalidInput);
    if (less == 0) {
      EXPECT_EQ(decoder.point_count(0), expected.point_count);
    }
  }
}

// Bounds cover the points of the stream, not the rest of the buffer.
TEST(BatchDecoder, BoundsStockStreams) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  size_t count = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    const std::span<const uint8_t> stream = open_container(sample.encoded.pieces[0].bytes)->streams[0];
    const PatchContainer input = open_stream(stream);
    const Mesh expected = must(decode_stream(draco_backend(), stream, sample.requests));
    if (sample.requests[0].component_type != ComponentType::kFloat32 || expected.point_count == 0) continue;
    if (input.point_count() > expected.point_count) ++count;
    Outputs outputs;
    float bounds[6];
    CudaPrimitive primitive = primitive_of(input, sample.requests, outputs);
    primitive.is_stitched = false;
    primitive.bounds = bounds;
    std::memset(outputs.values[0].data(), 0x7f, outputs.values[0].size());
    must(decode(decoder, primitive));
    const auto expected_bounds = bounds_of(expected.attributes[0].values.data(), expected.point_count);
    EXPECT_TRUE(std::ranges::equal(bounds, expected_bounds)) << sample.name;
  }
  EXPECT_GT(count, 5u);
}

// Bytes that are on the device already are read there.
TEST(BatchDecoder, TakesContainersOnTheDevice) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  const PatchedSample& sample = patched_samples(pool).front();
  std::vector<uint8_t> on_device = sample.encoded.pieces[0].bytes;
  Loaded loaded(sample);
  loaded.primitive.device_bytes = on_device.data();
  must(decode(decoder, loaded.primitive));
  loaded.expect_indices();
  // And only there.
  std::fill(on_device.begin(), on_device.end(), uint8_t{0});
  EXPECT_EQ(decode(decoder, loaded.primitive).code(), StatusCode::kInvalidInput);
}

// Places on grids give the floats that decoding gives, bit for bit.
TEST(BatchDecoder, WritesPlacesOnGrids) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  size_t count = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    if (sample.encoded.pieces[0].bytes.size() > kMostBytes) continue;
    const PatchContainer input = opened(sample.encoded.pieces[0].bytes);
    const Mesh& expected = sample.mesh;
    for (size_t i = 0; i < sample.requests.size(); ++i) {
      const AttributeRequest& request = sample.requests[i];
      if (request.component_type != ComponentType::kFloat32) continue;
      const uint32_t components = request.component_count, points = expected.point_count;
      std::vector<uint32_t> indices(3 * expected.faces.size());
      std::vector<uint16_t> places(size_t{components} * points);
      std::vector<float> grid(components + 1);
      CudaPrimitive primitive{.container = &input};
      primitive.indices = indices.data();
      primitive.attributes = {{request.unique_id, ComponentType::kUint16, request.component_count,
                               places.data(), 2 * components, grid.data()}};
      const Status status = decode(decoder, primitive);
      if (!status.ok()) {  // exact floats and normals have no grid
        EXPECT_EQ(status.code(), StatusCode::kUnsupported);
        continue;
      }
      ++count;
      for (size_t at = 0; at < places.size(); ++at) {
        float value;
        std::memcpy(&value, expected.attributes[i].values.data() + 4 * at, sizeof value);
        ASSERT_EQ(static_cast<float>(places[at]) * grid[components] + grid[at % components], value);
      }
    }
  }
  EXPECT_GT(count, 20u);
}

// Places in one array must be on one grid.
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
      const Expected<PatchContainer> one = open_container(mesh->pieces[0].bytes);
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
    primitive.attributes = {
        {small.requests[0].unique_id, ComponentType::kUint16, 3, places.data(), 6, grid.data()}};
    BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
    const Status status = decode(decoder, primitive);
    EXPECT_EQ(status.code(), second == &small ? StatusCode::kOk : StatusCode::kInvalidInput);
    EXPECT_EQ(status.place().patch, second == &small ? -1 : 1);
  }
}

// The rest of the batch is decoded.
TEST(BatchDecoder, RefusesWhatCannotBeAskedFor) {
  const ThreadPool pool(2);
  const PatchedSample& sample = patched_samples(pool).front();
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  const Loaded loaded(sample);
  const CudaPrimitive& good = loaded.primitive;
  const auto refused = [&](auto change) {
    Loaded bad(sample);
    change(bad.primitive);
    const CudaPrimitive batch[] = {bad.primitive, good};
    EXPECT_TRUE(decoder.start(batch).ok());
    const Status status = decoder.finish();
    EXPECT_EQ(status.place().primitive, 0);
    EXPECT_EQ(decoder.status(0).code(), status.code());
    EXPECT_EQ(decoder.point_count(0), 0u);
    EXPECT_TRUE(decoder.status(1).ok());
    loaded.expect_indices();
    std::memset(good.indices, 0, 12 * sample.mesh.faces.size());
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
  EXPECT_TRUE(decoder.finish().ok());  // an empty batch
  must(decode(decoder, good));
}

// The error names the broken patch. The values of the others are right, and no index is out of range.
TEST(BatchDecoder, BrokenPatchesHarmNoOther) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice({LaneOrder::kShuffled, 3})};
  std::mt19937 random(1);
  size_t refused = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    const auto whole = must(open_container(sample.encoded.pieces[0].bytes));
    if (whole.patch_count() < 3) continue;
    if (sample.encoded.pieces[0].bytes.size() > kMostBytes) continue;
    const Mesh& expected = sample.mesh;
    const uint32_t broken = static_cast<uint32_t>(random()) % whole.patch_count();
    std::vector<uint8_t> bytes = sample.encoded.pieces[0].bytes;
    const auto stream_at =
        static_cast<size_t>(whole.streams[broken].data() - sample.encoded.pieces[0].bytes.data());
    // Not the header, which the host reads.
    for (size_t at = whole.streams[broken].size() / 3; at < whole.streams[broken].size(); ++at)
      bytes[stream_at + at] = static_cast<uint8_t>(random());
    const PatchContainer container = opened(bytes);
    Outputs outputs;
    const Status status = decode(decoder, primitive_of(container, sample.requests, outputs));
    if (status.ok()) continue;
    ++refused;
    EXPECT_EQ(status.place().patch, broken) << status.to_string();
    for (size_t i = 0; i < size_t{3} * container.face_count(); ++i)
      ASSERT_LT(outputs.indices.data()[i], expected.point_count);
    for (uint32_t patch = 0; patch < container.entries.size(); ++patch) {
      if (patch == broken) continue;
      for (size_t k = 0; k < sample.requests.size(); ++k) {
        const size_t stride = expected.attributes[k].stride(), first = container.owned_base[patch] * stride;
        EXPECT_EQ(std::memcmp(outputs.values[k].data() + first, expected.attributes[k].values.data() + first,
                              container.owned_base[patch + 1] * stride - first),
                  0)
            << "patch " << patch;
      }
    }
  }
  EXPECT_GT(refused, 10u);
}

}  // namespace
}  // namespace psplit
