// The whole decoder of a device but for the device: every body of its kernels by the emulated warp, in several
// orders, against libdraco.
#include "decoder_cuda/batch_decoder.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "encoder/draco/draco_backend.h"
#include "src/cpu/cpu_backend.h"
#include "tests/decoder_cuda/emulated_device.h"
#include "tests/decoder_cuda/mutants.h"

namespace psplit {
namespace {

TEST(BatchDecoder, EqualsLibdracoInEveryOrderOfThreadsAndLanes) {
  const ThreadPool pool(2);
  std::vector<BatchDecoder<EmulatedDevice>> decoders;
  for (const LaneOrder& order : kLaneOrders) decoders.emplace_back(EmulatedDevice(order));
  size_t count = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    const std::vector<uint8_t>& container = sample.encoded.container;
    const Expected<Mesh> expected = draco_backend().decode_container(container, sample.requests, pool);
    ASSERT_TRUE(expected) << expected.status().to_string();
    const Expected<Mesh> decoded =
        decode_to_host(decoders[count++ % decoders.size()], container, sample.requests);
    ASSERT_TRUE(decoded) << decoded.status().to_string();
    EXPECT_TRUE(same_bits(*decoded, *expected));
  }
}

// Where a primitive of a batch is decoded to.
struct Outputs {
  EmulatedDevice::Array<uint32_t> indices;
  std::vector<EmulatedDevice::Array<uint8_t>> values;
};

BatchPrimitive batch_primitive(std::span<const uint8_t> bytes, const Container& container,
                               std::span<const AttributeRequest> requests, Outputs& outputs) {
  (void)outputs.indices.reserve(size_t{3} * container.face_count());
  outputs.values.resize(requests.size());
  BatchPrimitive primitive{bytes, &container, {}, outputs.indices.data(), 4};
  for (size_t i = 0; i < requests.size(); ++i) {
    const auto stride =
        static_cast<uint32_t>(component_bytes(requests[i].component_type)) * requests[i].component_count;
    (void)outputs.values[i].reserve(size_t{container.point_count()} * stride);
    primitive.targets.push_back({requests[i].unique_id, stored_type(requests[i].component_type),
                                 requests[i].component_count, outputs.values[i].data(), stride, nullptr});
  }
  return primitive;
}

TEST(BatchDecoder, TakesManyPrimitivesAtOnce) {
  const ThreadPool pool(2);
  const std::vector<PatchedSample> samples = patched_samples(pool);
  std::vector<Container> containers;
  for (const PatchedSample& sample : samples) {
    Expected<Container> container = parse_container(sample.encoded.container);
    ASSERT_TRUE(container);
    containers.push_back(std::move(*container));
  }
  std::vector<Outputs> outputs(samples.size());
  std::vector<BatchPrimitive> primitives;
  for (size_t i = 0; i < samples.size(); ++i)
    primitives.push_back(
        batch_primitive(samples[i].encoded.container, containers[i], samples[i].requests, outputs[i]));
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  ASSERT_TRUE(decoder.start(primitives).ok());
  const Status status = decoder.finish();
  ASSERT_TRUE(status.ok()) << status.to_string();
  for (size_t i = 0; i < samples.size(); ++i) {
    const Expected<Mesh> expected =
        draco_backend().decode_container(samples[i].encoded.container, samples[i].requests, pool);
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
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    const Expected<Container> container = parse_container(sample.encoded.container);
    const Expected<Mesh> expected =
        draco_backend().decode_container(sample.encoded.container, sample.requests, pool);
    ASSERT_TRUE(container && expected);
    uint32_t stride = 4;  // and four bytes between points that nobody writes to
    for (const Attribute& attribute : expected->attributes) stride += static_cast<uint32_t>(attribute.stride());
    std::vector<uint16_t> indices(3 * expected->faces.size());
    std::vector<uint8_t> points(size_t{stride} * expected->point_count, 0x5a);
    BatchPrimitive primitive{sample.encoded.container, &*container, {}, indices.data(), 2};
    size_t offset = 0;
    for (size_t i = 0; i < sample.requests.size(); offset += expected->attributes[i++].stride())
      primitive.targets.push_back({sample.requests[i].unique_id, stored_type(sample.requests[i].component_type),
                                   sample.requests[i].component_count, points.data() + offset, stride,
                                   nullptr});
    const Status started = decoder.start({&primitive, 1});
    if (expected->point_count > 0xffff) {
      EXPECT_EQ(started.code(), StatusCode::kUsage);
      continue;
    }
    ASSERT_TRUE(started.ok()) << started.to_string();
    ASSERT_TRUE(decoder.finish().ok());
    for (size_t i = 0; i < indices.size(); ++i) ASSERT_EQ(indices[i], expected->faces[i / 3][i % 3]);
    for (size_t point = 0; point < expected->point_count; ++point) {
      const uint8_t* at = points.data() + point * stride;
      for (const Attribute& attribute : expected->attributes) {
        ASSERT_EQ(std::memcmp(at, attribute.values.data() + point * attribute.stride(), attribute.stride()), 0);
        at += attribute.stride();
      }
      ASSERT_TRUE(std::all_of(at, at + 4, [](uint8_t byte) { return byte == 0x5a; }));
    }
  }
}

TEST(BatchDecoder, DecodesInPartsWhereMemoryIsShort) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice({LaneOrder::kDescending})};
  for (const uint64_t limit : {uint64_t{1}, uint64_t{400'000}}) {
    decoder.set_workspace_limit(limit);
    for (const PatchedSample& sample : patched_samples(pool)) {
      const Expected<Mesh> expected =
          cpu_backend().decode_container(sample.encoded.container, sample.requests, pool);
      const Expected<Mesh> decoded = decode_to_host(decoder, sample.encoded.container, sample.requests);
      ASSERT_TRUE(decoded) << sample.name << ": " << decoded.status().to_string();
      EXPECT_TRUE(same_bits(*decoded, *expected)) << sample.name;
    }
  }
}

// Patches [1, 4) of each mesh as they are, one after the other.
TEST(BatchDecoder, DecodesSomePatchesWithoutStitching) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice({LaneOrder::kShuffled, 5})};
  size_t count = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    const Expected<Container> container = parse_container(sample.encoded.container);
    ASSERT_TRUE(container);
    constexpr uint32_t kFirst = 1;
    const uint32_t end = std::min<uint32_t>(4, static_cast<uint32_t>(container->entries.size()));
    std::vector<Mesh> expected;
    size_t faces = 0, points = 0;
    for (uint32_t i = kFirst; i < end; ++i) {
      Expected<Mesh> patch = draco_backend().decode_stream(container->streams[i], sample.requests);
      ASSERT_TRUE(patch);
      patch->faces.resize(container->entries[i].face_count);  // a residue may have more
      faces += patch->faces.size();
      points += patch->point_count;
      expected.push_back(std::move(*patch));
    }
    std::vector<uint32_t> indices(3 * faces);
    std::vector<float> bounds(6 * expected.size());
    std::vector<std::vector<uint8_t>> values;
    BatchPrimitive primitive{sample.encoded.container, &*container, {}, indices.data(), 4, false, kFirst, 4};
    for (const AttributeRequest& request : sample.requests) {
      const auto stride =
          static_cast<uint32_t>(component_bytes(request.component_type)) * request.component_count;
      values.emplace_back(points * stride);
      primitive.targets.push_back({request.unique_id, stored_type(request.component_type),
                                   request.component_count, values.back().data(), stride, nullptr});
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

// Streams for themselves, all of all meshes in one batch, as stock Draco has them.
TEST(BatchDecoder, TakesStockStreams) {
  const ThreadPool pool(2);
  const std::vector<PatchedSample> samples = patched_samples(pool);
  std::vector<Container> containers, streams;
  std::vector<size_t> sample_of_stream;
  for (size_t i = 0; i < samples.size(); ++i) {
    containers.push_back(*parse_container(samples[i].encoded.container));
    for (size_t n = 0; n < containers.back().streams.size(); ++n) {
      Expected<Container> stream =
          container_of_stream(containers.back().streams[n], containers.back().entries[n].point_count);
      ASSERT_TRUE(stream);
      streams.push_back(std::move(*stream));
      sample_of_stream.push_back(i);
    }
  }
  std::vector<Outputs> outputs(streams.size());
  std::vector<BatchPrimitive> primitives;
  for (size_t n = 0; n < streams.size(); ++n)
    primitives.push_back(
        batch_primitive(streams[n].streams[0], streams[n], samples[sample_of_stream[n]].requests, outputs[n]));
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  ASSERT_TRUE(decoder.start(primitives).ok());
  const Status status = decoder.finish();
  ASSERT_TRUE(status.ok()) << status.to_string();
  for (size_t n = 0; n < streams.size(); ++n) {
    const PatchedSample& sample = samples[sample_of_stream[n]];
    const Expected<Mesh> expected = draco_backend().decode_stream(streams[n].streams[0], sample.requests);
    ASSERT_TRUE(expected);
    EXPECT_EQ(std::memcmp(outputs[n].indices.data(), expected->faces.data(), 12 * expected->faces.size()), 0);
    for (size_t k = 0; k < sample.requests.size(); ++k) {
      const Array<std::byte>& values = expected->attributes[k].values;
      EXPECT_EQ(std::memcmp(outputs[n].values[k].data(), values.data(), values.size()), 0) << sample.name;
    }
  }
}

// What places on grids stand for is what floats are decoded to, bit for bit.
TEST(BatchDecoder, WritesPlacesOnGrids) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  size_t count = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    const Expected<Container> container = parse_container(sample.encoded.container);
    const Expected<Mesh> expected =
        cpu_backend().decode_container(sample.encoded.container, sample.requests, pool);
    ASSERT_TRUE(container && expected);
    for (size_t i = 0; i < sample.requests.size(); ++i) {
      const AttributeRequest& request = sample.requests[i];
      if (request.component_type != ComponentType::kFloat32) continue;
      const uint32_t components = request.component_count, points = expected->point_count;
      std::vector<uint32_t> indices(3 * expected->faces.size());
      std::vector<uint16_t> places(size_t{components} * points);
      std::vector<float> grid(components + 1);
      BatchPrimitive primitive{sample.encoded.container, &*container, {}, indices.data()};
      primitive.targets = {{request.unique_id, core::DataType::kUint16, request.component_count,
                            reinterpret_cast<uint8_t*>(places.data()), 2 * components, grid.data()}};
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

// One attribute of several: the others take memory as well.
TEST(BatchDecoder, DecodesSomeAttributesOnly) {
  const ThreadPool pool(2);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  size_t count = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    if (sample.requests.size() < 2) continue;
    ++count;
    const std::vector<AttributeRequest> first{sample.requests.front()};
    const Expected<Mesh> expected = cpu_backend().decode_container(sample.encoded.container, first, pool);
    const Expected<Mesh> decoded = decode_to_host(decoder, sample.encoded.container, first);
    ASSERT_TRUE(decoded) << sample.name << ": " << decoded.status().to_string();
    EXPECT_TRUE(same_bits(*decoded, *expected)) << sample.name;
  }
  EXPECT_GT(count, 10u);
}

TEST(BatchDecoder, RefusesWhatCannotBeAskedFor) {
  const ThreadPool pool(2);
  const PatchedSample sample = patched_samples(pool).front();
  const Expected<Container> container = parse_container(sample.encoded.container);
  ASSERT_TRUE(container);
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice()};
  Outputs outputs;
  const BatchPrimitive good = batch_primitive(sample.encoded.container, *container, sample.requests, outputs);
  const auto refused = [&](auto change) {
    BatchPrimitive bad = good;
    change(bad);
    return decoder.start({&bad, 1}).code();
  };
  float bounds[6];
  EXPECT_EQ(refused([](BatchPrimitive& bad) { bad.index_bytes = 3; }), StatusCode::kUsage);
  EXPECT_EQ(refused([](BatchPrimitive& bad) { bad.first = 1; }), StatusCode::kUsage);
  EXPECT_EQ(refused([](BatchPrimitive& bad) { bad.end = 1; }), StatusCode::kUsage);
  EXPECT_EQ(refused([](BatchPrimitive& bad) { bad.is_stitched = false, bad.first = 3, bad.end = 2; }),
            StatusCode::kUsage);
  EXPECT_EQ(refused([&](BatchPrimitive& bad) { bad.bounds = bounds; }), StatusCode::kUsage);
  EXPECT_EQ(refused([&](BatchPrimitive& bad) {
              bad.is_stitched = false, bad.bounds = bounds, bad.targets[0].components = 2;
            }),
            StatusCode::kUsage);
  EXPECT_EQ(refused([](BatchPrimitive& bad) { bad.targets[0].stride = 11; }), StatusCode::kUsage);
  EXPECT_TRUE(decoder.finish().ok());  // of nothing
  BatchPrimitive wrong = good;
  wrong.targets[0].type = core::DataType::kInt16;
  ASSERT_TRUE(decoder.start({&wrong, 1}).ok());
  EXPECT_EQ(decoder.finish().code(), StatusCode::kUnsupported);
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
    const Expected<Container> whole = parse_container(sample.encoded.container);
    ASSERT_TRUE(whole);
    if (whole->patch_count() < 3) continue;
    const Expected<Mesh> expected =
        draco_backend().decode_container(sample.encoded.container, sample.requests, pool);
    ASSERT_TRUE(expected);
    const uint32_t broken = static_cast<uint32_t>(random()) % whole->patch_count();
    std::vector<uint8_t> bytes = sample.encoded.container;
    const auto stream_at = static_cast<size_t>(whole->streams[broken].data() - sample.encoded.container.data());
    // Behind the header, which the host reads.
    for (size_t at = whole->streams[broken].size() / 3; at < whole->streams[broken].size(); ++at)
      bytes[stream_at + at] = static_cast<uint8_t>(random());
    const Expected<Container> container = parse_container(bytes);
    ASSERT_TRUE(container);
    Outputs outputs;
    const BatchPrimitive primitive = batch_primitive(bytes, *container, sample.requests, outputs);
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

TEST(BatchDecoder, TakesAndRefusesMutantsAsTheCpuDoes) {
  BatchDecoder<EmulatedDevice> decoder{EmulatedDevice({LaneOrder::kShuffled, 4})};
  expect_mutants_as_on_cpu([&](std::span<const uint8_t> bytes, std::span<const AttributeRequest> requests) {
    return decode_to_host(decoder, bytes, requests);
  });
}

}  // namespace
}  // namespace psplit
