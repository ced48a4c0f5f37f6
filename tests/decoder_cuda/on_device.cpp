// CudaDecoder on the GPU of this machine. Built if there is a CUDA toolkit, skipped if there is no device.
#include <cuda_runtime_api.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "decoder_cuda/psplit_cuda.h"
#include "encoder/draco/draco_backend.h"
#include "src/container/patch_container.h"
#include "src/cpu/cpu_backend.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/patched_samples.h"

namespace psplit {
namespace {

// Memory that the device and the host share.
template <typename T>
struct Managed {
  T* data = nullptr;
  explicit Managed(size_t count) {
    void* memory = nullptr;
    EXPECT_EQ(cudaMallocManaged(&memory, count * sizeof(T)), cudaSuccess);
    data = static_cast<T*>(memory);
  }
  ~Managed() { (void)cudaFree(data); }
  Managed(const Managed&) = delete;
  Managed& operator=(const Managed&) = delete;
};

TEST(CudaDecoder, DecodesPatchesWithoutStitching) {
  std::string why;
  if (!cuda_available(&why)) GTEST_SKIP() << why;
  const ThreadPool pool;
  Expected<CudaDecoder> decoder = CudaDecoder::create();
  ASSERT_TRUE(decoder) << decoder.status().to_string();
  decoder->set_memory_limit(1);
  for (const PatchedSample& sample : patched_samples(pool)) {
    const Expected<PatchContainer> container = open_container(sample.encoded.container);
    ASSERT_TRUE(container);
    if (sample.requests[0].component_type != ComponentType::kFloat32 || container->has_residue) continue;
    const uint32_t last = container->patch_count() - 1, points = container->entries[last].point_count;
    const size_t faces = container->entries[last].face_count;
    const Expected<Mesh> expected = decode_stream(draco_backend(), container->streams[last], sample.requests);
    ASSERT_TRUE(expected);
    const Managed<uint16_t> indices(3 * faces);
    const Managed<float> positions(size_t{3} * points), bounds(6);
    CudaPrimitive primitive;
    primitive.container = &*container;
    primitive.attributes = {{sample.requests[0].unique_id, ComponentType::kFloat32, 3, positions.data, 12}};
    primitive.indices = indices.data;
    primitive.index_bytes = 2;
    primitive.is_stitched = false;
    primitive.first = last;
    primitive.bounds = bounds.data;
    const PatchContainer stock = open_stream(container->streams[last], points);
    for (const bool as_stock : {false, true}) {
      if (as_stock) {
        primitive.container = &stock;
        primitive.first = 0;
      }
      ASSERT_TRUE(decoder->start({&primitive, 1}).ok());
      const Status status = decoder->finish();
      if (points > 0xffff) {
        EXPECT_EQ(status.code(), StatusCode::kUsage);
        continue;
      }
      ASSERT_TRUE(status.ok()) << status.to_string();
      if (as_stock) {
        EXPECT_EQ(decoder->point_count(0), points);
      }
      for (size_t i = 0; i < 3 * faces; ++i) ASSERT_EQ(indices.data[i], expected->faces[i / 3][i % 3]);
      EXPECT_EQ(std::memcmp(positions.data, expected->attributes[0].values.data(), size_t{12} * points), 0);
      for (uint32_t k = 0; k < 3; ++k) {
        float low = positions.data[k], high = positions.data[k];
        for (uint32_t point = 1; point < points; ++point) {
          low = std::min(low, positions.data[3 * point + k]);
          high = std::max(high, positions.data[3 * point + k]);
        }
        EXPECT_EQ(bounds.data[k], low);
        EXPECT_EQ(bounds.data[3 + k], high);
      }
    }
  }
}

// Containers from the host and on the device, a whole one and a window, and a broken one, in one batch.
TEST(CudaDecoder, DecodesManyAtOnceFromEitherMemory) {
  std::string why;
  if (!cuda_available(&why)) GTEST_SKIP() << why;
  const ThreadPool pool;
  Expected<CudaDecoder> decoder = CudaDecoder::create();
  ASSERT_TRUE(decoder) << decoder.status().to_string();
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    const std::vector<uint8_t>& bytes = sample.encoded.container;
    const Expected<PatchContainer> container = open_container(bytes);
    const Expected<Mesh> expected = decode_container(draco_backend(), bytes, sample.requests, pool);
    ASSERT_TRUE(container && expected);
    if (sample.requests[0].component_type != ComponentType::kFloat32) continue;
    const Managed<uint8_t> on_device(bytes.size());
    std::copy(bytes.begin(), bytes.end(), on_device.data);
    const uint32_t points = expected->point_count, last = static_cast<uint32_t>(container->entries.size()) - 1;
    const size_t faces = expected->faces.size();
    const Managed<uint32_t> indices(12 * faces);
    const Managed<float> positions(size_t{12} * points);
    std::vector<CudaPrimitive> batch(4);
    for (size_t i = 0; i < batch.size(); ++i) {
      batch[i].container = &*container;
      batch[i].indices = indices.data + 3 * faces * i;
      batch[i].attributes = {{sample.requests[0].unique_id, ComponentType::kFloat32, 3,
                              positions.data + size_t{3} * points * i, 12}};
    }
    batch[1].device_bytes = on_device.data;
    std::vector<uint8_t> broken_bytes = bytes;
    const size_t stream_at = static_cast<size_t>(container->streams[last].data() - bytes.data());
    // Not the stream's header, which the host reads.
    std::fill(broken_bytes.begin() + static_cast<ptrdiff_t>(stream_at + container->streams[last].size() / 3),
              broken_bytes.end(), uint8_t{0xff});
    const Expected<PatchContainer> broken = open_container(broken_bytes);
    ASSERT_TRUE(broken) << broken.status().to_string();
    batch[2].container = &*broken;
    batch[3].first = last;
    ASSERT_TRUE(decoder->start(batch).ok());
    // Any bytes are valid values of attributes that are stored raw.
    const bool is_broken = !decode_container(cpu_backend(), broken_bytes, sample.requests, pool);
    const Status finished = decoder->finish();
    EXPECT_EQ(finished.ok(), !is_broken);
    if (is_broken) {
      EXPECT_EQ(finished.place().primitive, 2);
    }
    const auto* const values = reinterpret_cast<const float*>(expected->attributes[0].values.data());
    for (const size_t i : {0u, 1u, 3u}) {
      EXPECT_TRUE(decoder->status(i).ok()) << decoder->status(i).to_string();
      const uint32_t first_face = i == 3 ? container->face_base[last] : 0;
      const uint32_t first_point = i == 3 ? container->owned_base[last] : 0;
      EXPECT_EQ(std::memcmp(indices.data + 3 * faces * i, expected->faces.data() + first_face,
                            12 * (faces - first_face)),
                0);
      EXPECT_EQ(std::memcmp(positions.data + size_t{3} * points * i, values + size_t{3} * first_point,
                            size_t{12} * (points - first_point)),
                0);
    }
  }
}

// Results are the same if there is memory for only a few patches.
TEST(CudaDecoder, DecodesInWindowsWhereMemoryIsShort) {
  std::string why;
  if (!cuda_available(&why)) GTEST_SKIP() << why;
  const ThreadPool pool;
  const std::vector<PatchedSample> samples = patched_samples(pool);
  std::vector<PatchContainer> containers;
  for (const PatchedSample& sample : samples) containers.push_back(*open_container(sample.encoded.container));
  std::vector<DecodeTask> tasks;
  for (size_t i = 0; i < samples.size(); ++i) tasks.push_back({&containers[i], samples[i].requests});
  const std::vector<Expected<Mesh>> expected = draco_backend().decode(tasks, pool, {});
  for (const uint64_t limit : {uint64_t{1}, uint64_t{4'000'000}, uint64_t{0}}) {
    const std::vector<Expected<Mesh>> decoded = cuda_backend(limit).decode(tasks, pool, {});
    for (size_t i = 0; i < tasks.size(); ++i) {
      ASSERT_TRUE(decoded[i]) << samples[i].name << ": " << decoded[i].status().to_string();
      EXPECT_TRUE(same_bits(*decoded[i], *expected[i])) << samples[i].name;
    }
  }
}

}  // namespace
}  // namespace psplit
