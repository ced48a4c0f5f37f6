// CudaDecoder on the GPU of this machine. Built if there is a CUDA toolkit, skipped if there is no device.
#include <cuda_runtime_api.h>

#include <algorithm>
#include <cstring>
#include <optional>

#include "psplit/cuda.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "src/container/patch_container.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/patched_samples.h"
#include "tests/support/same_bits.h"

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
  CudaDecoder decoder = must(CudaDecoder::create());
  decoder.set_memory_limit(1);
  for (const PatchedSample& sample : patched_samples(pool)) {
    const PatchContainer container = must(open_container(sample.encoded.pieces[0].bytes));
    if (sample.requests[0].component_type != ComponentType::kFloat32 || container.has_residue) continue;
    const uint32_t last = container.patch_count() - 1, points = container.entries[last].point_count;
    const size_t faces = container.entries[last].face_count;
    const Mesh expected = must(decode_stream(draco_backend(), container.streams[last], sample.requests));
    const Managed<uint16_t> indices(3 * faces);
    const Managed<float> positions(size_t{3} * points), bounds(6);
    CudaPrimitive primitive{
        .container = &container,
        .attributes = {{sample.requests[0].unique_id, ComponentType::kFloat32, 3, positions.data, 12}},
        .indices = indices.data,
        .index_bytes = 2,
        .is_stitched = false,
        .first = last,
        .bounds = bounds.data};
    const PatchContainer stock = open_stream(container.streams[last], points);
    for (const bool as_stock : {false, true}) {
      if (as_stock) {
        primitive.container = &stock;
        primitive.first = 0;
      }
      ASSERT_TRUE(decoder.start({&primitive, 1}).ok());
      const Status status = decoder.finish();
      if (points > 0xffff) {
        EXPECT_EQ(status.code(), StatusCode::kUsage);
        continue;
      }
      ASSERT_TRUE(status.ok()) << status.to_string();
      if (as_stock) {
        EXPECT_EQ(decoder.point_count(0), points);
      }
      for (size_t i = 0; i < 3 * faces; ++i) ASSERT_EQ(indices.data[i], expected.faces[i / 3][i % 3]);
      EXPECT_EQ(std::memcmp(positions.data, expected.attributes[0].values.data(), size_t{12} * points), 0);
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
  CudaDecoder decoder = must(CudaDecoder::create());
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    const std::vector<uint8_t>& bytes = sample.encoded.pieces[0].bytes;
    const PatchContainer container = must(open_container(bytes));
    const Mesh& expected = sample.mesh;
    if (sample.requests[0].component_type != ComponentType::kFloat32) continue;
    const Managed<uint8_t> on_device(bytes.size());
    std::copy(bytes.begin(), bytes.end(), on_device.data);
    const uint32_t points = expected.point_count, last = static_cast<uint32_t>(container.entries.size()) - 1;
    const size_t faces = expected.faces.size();
    const Managed<uint32_t> indices(12 * faces);
    const Managed<float> positions(size_t{12} * points);
    std::vector<CudaPrimitive> batch(4);
    for (size_t i = 0; i < batch.size(); ++i) {
      batch[i].container = &container;
      batch[i].indices = indices.data + 3 * faces * i;
      batch[i].attributes = {{sample.requests[0].unique_id, ComponentType::kFloat32, 3,
                              positions.data + size_t{3} * points * i, 12}};
    }
    batch[1].device_bytes = on_device.data;
    std::vector<uint8_t> broken_bytes = bytes;
    const size_t stream_at = static_cast<size_t>(container.streams[last].data() - bytes.data());
    // Not the stream's header, which the host reads.
    std::fill(broken_bytes.begin() + static_cast<ptrdiff_t>(stream_at + container.streams[last].size() / 3),
              broken_bytes.end(), uint8_t{0xff});
    const PatchContainer broken = must(open_container(broken_bytes));
    batch[2].container = &broken;
    batch[3].first = last;
    ASSERT_TRUE(decoder.start(batch).ok());
    // Any bytes are valid values of attributes that are stored raw.
    const bool is_broken = !decode_container(cpu_backend(), broken_bytes, sample.requests, pool);
    const Status finished = decoder.finish();
    EXPECT_EQ(finished.ok(), !is_broken);
    if (is_broken) {
      EXPECT_EQ(finished.place().primitive, 2);
    }
    const auto* const values = reinterpret_cast<const float*>(expected.attributes[0].values.data());
    for (const size_t i : {0u, 1u, 3u}) {
      EXPECT_TRUE(decoder.status(i).ok()) << decoder.status(i).to_string();
      const uint32_t first_face = i == 3 ? container.face_base[last] : 0;
      const uint32_t first_point = i == 3 ? container.owned_base[last] : 0;
      EXPECT_EQ(std::memcmp(indices.data + 3 * faces * i, expected.faces.data() + first_face,
                            12 * (faces - first_face)),
                0);
      EXPECT_EQ(std::memcmp(positions.data + size_t{3} * points * i, values + size_t{3} * first_point,
                            size_t{12} * (points - first_point)),
                0);
    }
  }
}

// Decodes one sample as engines do: in the caller's memory, without waiting, again, and in a graph.
class CudaBatchOnDevice : public testing::Test {
 protected:
  void SetUp() override {
    std::string why;
    if (!cuda_available(&why)) GTEST_SKIP() << why;
    ASSERT_EQ(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), cudaSuccess);
    const ThreadPool pool;
    const std::vector<PatchedSample>& samples = patched_samples(pool);
    const auto found = std::find_if(samples.begin(), samples.end(), [](const PatchedSample& each) {
      const Expected<PatchContainer> opened = open_container(each.encoded.pieces[0].bytes);
      return each.requests[0].component_type == ComponentType::kFloat32 && opened && opened->patch_count() > 3;
    });
    ASSERT_NE(found, samples.end());
    sample = *found;
    container = *open_container(sample.encoded.pieces[0].bytes);
    expected = sample.mesh;
    indices.emplace(3 * expected.faces.size());
    positions.emplace(size_t{3} * expected.point_count);
    primitive.container = &container;
    primitive.indices = indices->data;
    primitive.attributes = {{sample.requests[0].unique_id, ComponentType::kFloat32, 3, positions->data, 12}};
  }
  void TearDown() override {
    if (stream != nullptr) (void)cudaStreamDestroy(stream);
  }
  void forget() {
    std::fill_n(indices->data, 3 * expected.faces.size(), 0xffffffffu);
    std::fill_n(positions->data, size_t{3} * expected.point_count, -1.0f);
  }
  void expect_mesh() const {
    EXPECT_EQ(std::memcmp(indices->data, expected.faces.data(), 12 * expected.faces.size()), 0);
    EXPECT_EQ(
        std::memcmp(positions->data, expected.attributes[0].values.data(), size_t{12} * expected.point_count),
        0);
  }

  cudaStream_t stream = nullptr;
  PatchedSample sample;
  PatchContainer container;
  Mesh expected;
  std::optional<Managed<uint32_t>> indices;
  std::optional<Managed<float>> positions;
  CudaPrimitive primitive;
};

TEST_F(CudaBatchOnDevice, DecodesInTheCallersMemoryAsOftenAsItIsEnqueued) {
  ASSERT_TRUE(cuda_warm_up().ok());
  CudaBatch batch = CudaBatch::plan({&primitive, 1});
  CudaMemory memory = must(CudaMemory::allocate(batch.workspace_bytes()));
  EXPECT_EQ(batch.enqueue(stream).code(), StatusCode::kUsage);
  EXPECT_EQ(batch.prepare(memory.data() + 16).code(), StatusCode::kUsage);
  ASSERT_TRUE(batch.prepare(memory.data()).ok());
  EXPECT_EQ(batch.finish().code(), StatusCode::kUsage);
  for (int time = 0; time < 3; ++time) {
    forget();
    if (time == 1) {
      ASSERT_TRUE(batch.upload(stream).ok());
    }
    ASSERT_TRUE(batch.enqueue(stream).ok());
    for (Expected<bool> done = false; !*done;) {
      done = batch.poll();
      ASSERT_TRUE(done);
    }
    const Status status = batch.finish();
    ASSERT_TRUE(status.ok()) << status.to_string();
    EXPECT_TRUE(batch.status(0).ok());
    expect_mesh();
  }
}

TEST_F(CudaBatchOnDevice, IsCapturedInAGraph) {
  CudaBatch batch = CudaBatch::plan({&primitive, 1});
  ASSERT_TRUE(batch.prepare().ok());
  cudaGraph_t graph = nullptr;
  cudaGraphExec_t launched = nullptr;
  ASSERT_EQ(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal), cudaSuccess);
  const Status enqueued = batch.enqueue(stream);
  ASSERT_EQ(cudaStreamEndCapture(stream, &graph), cudaSuccess);
  ASSERT_TRUE(enqueued.ok()) << enqueued.to_string();
  ASSERT_EQ(cudaGraphInstantiateWithFlags(&launched, graph, 0), cudaSuccess);
  for (int time = 0; time < 2; ++time) {
    forget();
    ASSERT_EQ(cudaGraphLaunch(launched, stream), cudaSuccess);
    ASSERT_EQ(cudaStreamSynchronize(stream), cudaSuccess);
    must(batch.finish());
    expect_mesh();
  }
  (void)cudaGraphExecDestroy(launched);
  (void)cudaGraphDestroy(graph);
}

// A graph that was never launched has uploaded nothing.
TEST_F(CudaBatchOnDevice, UploadsAgainAfterAnUploadInAGraph) {
  CudaBatch batch = CudaBatch::plan({&primitive, 1});
  ASSERT_TRUE(batch.prepare().ok());
  cudaGraph_t graph = nullptr;
  ASSERT_EQ(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal), cudaSuccess);
  const Status uploaded = batch.upload(stream);
  ASSERT_EQ(cudaStreamEndCapture(stream, &graph), cudaSuccess);
  ASSERT_TRUE(uploaded.ok()) << uploaded.to_string();
  (void)cudaGraphDestroy(graph);
  forget();
  ASSERT_TRUE(batch.enqueue(stream).ok());
  must(batch.finish());
  expect_mesh();
}

// First in memory of its own on CUDA's default stream, then in another workspace.
TEST_F(CudaBatchOnDevice, IsPreparedAgain) {
  const ThreadPool pool(2);
  CudaBatch batch = CudaBatch::plan({&primitive, 1}, ~uint64_t{0}, &pool);
  ASSERT_TRUE(batch.prepare(nullptr, &pool).ok());
  forget();
  ASSERT_TRUE(batch.enqueue(nullptr).ok());
  ASSERT_TRUE(batch.finish().ok());
  expect_mesh();
  CudaMemory memory = must(CudaMemory::allocate(batch.workspace_bytes()));
  ASSERT_TRUE(batch.prepare(memory.data()).ok());
  EXPECT_EQ(batch.finish().code(), StatusCode::kUsage);
  forget();
  ASSERT_TRUE(batch.enqueue(stream).ok());
  ASSERT_TRUE(batch.finish().ok());
  expect_mesh();
}

TEST(CudaQuick, ErrorsNameTheirCallAndDoNotStayBehind) {
  std::string why;
  if (!cuda_available(&why)) GTEST_SKIP() << why;
  const Expected<CudaMemory> memory = CudaMemory::allocate(size_t{1} << 50);
  ASSERT_FALSE(memory);
  EXPECT_EQ(memory.status().code(), StatusCode::kRuntimeFailure);
  EXPECT_EQ(memory.status().message().find("CUDA: cudaMalloc of 1125899906842624 bytes: "), 0u)
      << memory.status().to_string();
  EXPECT_EQ(cudaGetLastError(), cudaSuccess);
}

// Parts, and a container that is on the device already.
TEST_F(CudaBatchOnDevice, DecodesContainersOnTheDeviceInLittleMemory) {
  const std::vector<uint8_t>& bytes = sample.encoded.pieces[0].bytes;
  const Managed<uint8_t> on_device(bytes.size());
  std::copy(bytes.begin(), bytes.end(), on_device.data);
  primitive.device_bytes = on_device.data;
  CudaBatch whole = CudaBatch::plan({&primitive, 1}), parts = CudaBatch::plan({&primitive, 1}, 1);
  EXPECT_LT(parts.workspace_bytes(), whole.workspace_bytes());
  ASSERT_TRUE(parts.prepare().ok());
  forget();
  ASSERT_TRUE(parts.enqueue(stream).ok());
  must(parts.finish());
  expect_mesh();
}

// Results are the same if there is memory for only a few patches.
TEST(CudaDecoder, DecodesInWindowsWhereMemoryIsShort) {
  std::string why;
  if (!cuda_available(&why)) GTEST_SKIP() << why;
  const ThreadPool pool;
  const std::vector<PatchedSample>& samples = patched_samples(pool);
  std::vector<PatchContainer> containers;
  for (const PatchedSample& sample : samples)
    containers.push_back(*open_container(sample.encoded.pieces[0].bytes));
  std::vector<DecodeTask> tasks;
  for (size_t i = 0; i < samples.size(); ++i) tasks.push_back({&containers[i], samples[i].requests});
  for (const uint64_t limit : {uint64_t{1}, uint64_t{4'000'000}, uint64_t{0}}) {
    const std::vector<Expected<Mesh>> decoded = cuda_backend(limit).decode(tasks, pool, {});
    for (size_t i = 0; i < tasks.size(); ++i) {
      ASSERT_TRUE(decoded[i]) << samples[i].name << ": " << decoded[i].status().to_string();
      EXPECT_TRUE(same_bits(*decoded[i], samples[i].mesh)) << samples[i].name;
    }
  }
}

}  // namespace
}  // namespace psplit
