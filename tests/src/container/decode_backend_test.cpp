// The contract of DecodeBackend, by the CPU's: memory is asked for with counts, and opened containers are
// decoded as often as a caller likes.
#include <algorithm>
#include <atomic>

#include "psplit/decode.h"
#include "src/container/patch_container.h"
#include "tests/support/expect.h"
#include "tests/support/same_bits.h"
#include "tests/support/sample_containers.h"

namespace psplit {
namespace {

// Whole containers, and after each of them its first patch alone and its first stream as a stock stream.
class OpenedOnce : public testing::Test {
 protected:
  void SetUp() override {
    for (const SampleContainer& each : files) {
      const auto container = must(open_container(each.bytes));
      containers.push_back(container);
      containers.push_back(container.alone(0));
      containers.push_back(open_stream(container.streams[0]));
    }
    for (size_t i = 0; i < containers.size(); ++i) tasks.push_back({&containers[i], files[i / 3].requests});
  }

  const std::vector<SampleContainer> files = sample_containers();
  std::vector<PatchContainer> containers;
  std::vector<DecodeTask> tasks;
  const ThreadPool pool{2};
};

TEST_F(OpenedOnce, AsksForMemoryWithTheCounts) {
  std::vector<Mesh> meshes(tasks.size());
  const auto buffers_for = [&](size_t i, uint32_t points, uint32_t faces) {
    return allocate_mesh(points, faces, tasks[i].requests, containers[i].bytes.size(), meshes[i]);
  };
  const std::vector<Status> statuses = cpu_backend().decode_into(tasks, buffers_for, pool, {});
  ASSERT_EQ(statuses.size(), tasks.size());
  for (size_t i = 0; i < tasks.size(); ++i) {
    ASSERT_TRUE(statuses[i].ok()) << statuses[i].to_string();
    EXPECT_EQ(meshes[i].faces.size(), containers[i].face_count());
    EXPECT_LE(meshes[i].point_count, containers[i].point_count());
    if (containers[i].is_point_count_known) {
      EXPECT_EQ(meshes[i].point_count, containers[i].point_count());
    }
  }
  // A patch alone is its stream.
  for (size_t i = 0; i < tasks.size(); i += 3) EXPECT_TRUE(same_bits(meshes[i + 1], meshes[i + 2]));
}

TEST_F(OpenedOnce, DecodesAsOftenAsItIsAskedTo) {
  const std::vector<Expected<Mesh>> first = cpu_backend().decode(tasks, pool);
  const std::vector<Expected<Mesh>> second = cpu_backend().decode(tasks, pool);
  for (size_t i = 0; i < tasks.size(); ++i) {
    ASSERT_TRUE(first[i] && second[i]);
    EXPECT_TRUE(same_bits(*first[i], *second[i]));
    const Mesh single = must(cpu_backend().decode(containers[i], tasks[i].requests, pool));
    EXPECT_TRUE(same_bits(*first[i], single));
  }
}

TEST_F(OpenedOnce, AnErrorOfTheCallerEndsOneTask) {
  std::vector<Mesh> meshes(tasks.size());
  const auto buffers_for = [&](size_t i, uint32_t points, uint32_t faces) -> Expected<PrimitiveBuffers> {
    if (i % 3 == 1) return io_failure("no room");
    if (i % 3 == 2) return runtime_failure("no memory");
    return allocate_mesh(points, faces, tasks[i].requests, containers[i].bytes.size(), meshes[i]);
  };
  const std::vector<Status> statuses = cpu_backend().decode_into(tasks, buffers_for, pool, {});
  constexpr StatusCode kCodes[] = {StatusCode::kOk, StatusCode::kIo, StatusCode::kRuntimeFailure};
  for (size_t i = 0; i < tasks.size(); ++i)
    EXPECT_EQ(statuses[i].code(), kCodes[i % 3]) << statuses[i].to_string();
}

TEST_F(OpenedOnce, ProgressReachesItsTotalDespiteErrors) {
  std::vector<uint8_t> older(containers[2].bytes.begin(), containers[2].bytes.end());
  older[6] = 1;  // bitstream 2.1
  containers[2] = open_stream(older);
  ASSERT_FALSE(containers[2].refusal.ok());
  const auto no_memory = [](size_t, uint32_t, uint32_t) -> Expected<PrimitiveBuffers> {
    return io_failure("full");
  };
  std::atomic<size_t> furthest = 0, total = 0;
  const Progress progress = [&](size_t done, size_t of) {
    for (size_t before = furthest; before < done && !furthest.compare_exchange_weak(before, done);) continue;
    total = of;
  };
  for (const Status& status : cpu_backend().decode_into(tasks, no_memory, pool, {progress}))
    EXPECT_FALSE(status.ok());
  EXPECT_GT(total, 0u);
  EXPECT_EQ(furthest, total);
}

TEST_F(OpenedOnce, RefusedStreamsEndWithTheirRefusal) {
  std::vector<uint8_t> bytes(containers[1].bytes.begin(), containers[1].bytes.end());
  bytes[6] = 1;
  const PatchContainer older = open_stream(bytes);
  const Status status = cpu_backend().decode(older, tasks[1].requests, pool).status();
  EXPECT_EQ(status.code(), StatusCode::kUnsupported);
  EXPECT_EQ(status.message(), older.refusal.message());
}

TEST(AllocateMesh, RefusesCountsThatTheBytesDoNotJustify) {
  const std::vector<AttributeRequest> requests{{.semantic = "POSITION"}};
  Mesh mesh;
  EXPECT_EQ(allocate_mesh(100'000'000, 1, requests, 1000, mesh).status().code(), StatusCode::kInvalidInput);
  EXPECT_EQ(allocate_mesh(1, 100'000'000, requests, 1000, mesh).status().code(), StatusCode::kInvalidInput);
  const PrimitiveBuffers buffers = must(allocate_mesh(7, 5, requests, 1000, mesh));
  EXPECT_EQ(buffers.indices.size(), 60u);
  EXPECT_EQ(buffers.attributes[0].bytes.size(), 84u);
  EXPECT_EQ(buffers.attributes[0].stride, 12u);
  EXPECT_EQ(mesh.attributes[0].semantic, "POSITION");
}

}  // namespace
}  // namespace psplit
