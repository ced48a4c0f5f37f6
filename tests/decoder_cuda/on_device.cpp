// CudaDecoder on the GPU of this machine. Built where there is a CUDA toolkit, skipped where there is no
// device.
#include <cuda_runtime_api.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "decoder_cuda/psplit_cuda.h"
#include "encoder/draco/draco_backend.h"
#include "src/container/container.h"
#include "tests/support/patched_samples.h"

namespace psplit {
namespace {

// Memory that the device and the host see.
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
  decoder->set_workspace_limit(1);
  for (const PatchedSample& sample : patched_samples(pool)) {
    const Expected<Container> container = parse_container(sample.encoded.container);
    ASSERT_TRUE(container);
    if (sample.requests[0].component_type != ComponentType::kFloat32 || container->has_residue) continue;
    const uint32_t last = container->patch_count() - 1, points = container->entries[last].point_count;
    const size_t faces = container->entries[last].face_count;
    const Expected<Mesh> expected = draco_backend().decode_stream(container->streams[last], sample.requests);
    ASSERT_TRUE(expected);
    const Managed<uint16_t> indices(3 * faces);
    const Managed<float> positions(size_t{3} * points), bounds(6);
    CudaPrimitive primitive;
    primitive.container = sample.encoded.container;
    primitive.attributes = {{sample.requests[0].unique_id, ComponentType::kFloat32, 3, positions.data, 12}};
    primitive.indices = indices.data;
    primitive.index_bytes = 2;
    primitive.is_stitched = false;
    primitive.first = last;
    primitive.bounds = bounds.data;
    for (const bool as_stock : {false, true}) {
      if (as_stock) {
        primitive.container = container->streams[last];
        primitive.stream_points = points;
        primitive.first = 0;
      }
      Status status = decoder->start({&primitive, 1});
      if (points > 0xffff) {
        EXPECT_EQ(status.code(), StatusCode::kUsage);
        continue;
      }
      ASSERT_TRUE(status.ok()) << status.to_string();
      status = decoder->finish();
      ASSERT_TRUE(status.ok()) << status.to_string();
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

}  // namespace
}  // namespace psplit
