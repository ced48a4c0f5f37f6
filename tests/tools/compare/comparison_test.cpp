#include "tools/gltf_psplit/compare/comparison.h"

#include <gtest/gtest.h>

#include "encoder/draco/draco_backend.h"
#include "tools/gltf_psplit/shapes/shapes.h"

namespace psplit {
namespace {

TEST(Comparison, SumsOverMeshesAndTimesEveryDecoder) {
  const ThreadPool pool(2);
  const auto meshes = generate_shape({Shape::kScene, 12000, 1, true, true}, pool);
  ASSERT_TRUE(meshes.ok()) << meshes.status().to_string();
  uint64_t faces = 0, points = 0;
  for (const Mesh& mesh : *meshes) {
    faces += mesh.faces.size();
    points += mesh.point_count;
  }
  ComparisonOptions options;
  options.patch_counts = {6, 24};
  options.thread_counts = {1, 2};
  options.repeat = 1;
  options.stock_speeds = {10, 0, 10};
  const std::vector<DecodeBackend> backends{draco_backend()};
  size_t done = 0, total = 0;
  const auto comparison = compare_codecs(*meshes, options, backends, pool, [&](size_t now, size_t all) {
    EXPECT_EQ(now, ++done);
    total = all;
  });
  ASSERT_TRUE(comparison.ok()) << comparison.status().to_string();
  // Stock Draco at three speeds, meshoptimizer in two forms, and each split with two decoders and in stages.
  EXPECT_EQ(total, 2u * (3 + 2 + 2 * (2 + 1)));
  EXPECT_EQ(done, total);
  EXPECT_EQ(comparison->faces, faces);
  EXPECT_EQ(comparison->points, points);
  ASSERT_EQ(comparison->splits.size(), 2u);
  for (const SplitRow& row : comparison->splits) {
    EXPECT_EQ(row.summary.faces, faces);
    EXPECT_EQ(row.summary.points, points);
    EXPECT_GT(row.overhead, 0);
    ASSERT_EQ(row.decode.size(), 2u);
    EXPECT_EQ(row.decode[1].threads, 2);
    EXPECT_GT(row.decode[0].speedup, 0);
    EXPECT_NEAR(row.overhead,
                static_cast<double>(row.summary.total_bytes) / static_cast<double>(comparison->stock.bytes) - 1,
                1e-12);
    ASSERT_EQ(row.stages.size(), 5u);
    EXPECT_EQ(row.stages.front().name, "connectivity");
    for (const StageRow& stage : row.stages) EXPECT_GE(stage.timing.median_ms, 0) << stage.name;
    EXPECT_GT(row.stages.front().timing.median_ms, 0);
  }
  // The speed of the patches is always measured, and all ratios refer to it.
  ASSERT_EQ(comparison->stock_speeds.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(comparison->stock_speeds[i].speed, static_cast<int>(5 * i));
    EXPECT_GT(comparison->stock_speeds[i].decode.median_ms, 0);
  }
  EXPECT_EQ(comparison->stock.speed, 5);
  EXPECT_EQ(comparison->stock.bytes, comparison->stock_speeds[1].bytes);
  EXPECT_EQ(comparison->stock.decode.median_ms, comparison->stock_speeds[1].decode.median_ms);
  EXPECT_LT(comparison->stock_speeds[0].bytes, comparison->stock_speeds[2].bytes);
  EXPECT_LT(comparison->splits[0].summary.total_bytes, comparison->splits[1].summary.total_bytes);
  // Draco makes the smallest meshes.
  EXPECT_LT(comparison->stock.bytes, comparison->meshopt.bytes);
  EXPECT_LT(comparison->meshopt.bytes, comparison->meshopt_plain.bytes);
  EXPECT_GT(comparison->meshopt.decode.median_ms, 0);
  EXPECT_GT(comparison->meshopt_plain.decode.median_ms, 0);
}

TEST(Comparison, ReportsADecoderThatLosesFaces) {
  const ThreadPool pool(1);
  const auto meshes = generate_shape({Shape::kBlob, 2000, 1, false, false}, pool);
  ASSERT_TRUE(meshes.ok());
  ComparisonOptions options;
  options.patch_counts = {2};
  options.thread_counts = {1};
  DecodeBackend lossy = draco_backend();
  lossy.decode_into = [](std::span<const DecodeTask> tasks, const BuffersFor& buffers_for, const ThreadPool&,
                         const Watch&) {
    const PatchContainer& container = *tasks.front().container;
    return std::vector<Status>{buffers_for(0, container.point_count(), container.face_count() - 1).status()};
  };
  const auto comparison = compare_codecs(*meshes, options, std::vector{lossy}, pool);
  ASSERT_FALSE(comparison.ok());
  EXPECT_EQ(comparison.status().code(), StatusCode::kDiffers);
}

}  // namespace
}  // namespace psplit
