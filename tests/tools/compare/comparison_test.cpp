#include "tools/gltf_psplit/compare/comparison.h"

#include <algorithm>

#include "gltf_ext/convert/read_jobs.h"
#include "gltf_ext/json/json.h"
#include "psplit/document.h"
#include "psplit/encode.h"
#include "psplit/gltf.h"
#include "tests/gltf_ext/asset.h"
#include "tests/support/reproducible_meshes.h"
#include "tools/gltf_psplit/compare/meshopt_rival.h"
#include "tools/gltf_psplit/shapes/shapes.h"

namespace psplit {
namespace {

Document document_of(std::span<const Mesh> meshes) {
  Document document = document_from_mesh(meshes.front());
  for (const Mesh& mesh : meshes.subspan(1)) add_mesh(document, mesh);
  return document;
}

std::vector<EncodeJob> read_all(const Document& document, const EncodeDocumentOptions& coding) {
  Expected<PlannedJobs> read = read_and_plan(document, coding, draco_backend(), ThreadPool(2));
  if (!read) {
    ADD_FAILURE() << read.status().to_string();
    return {};
  }
  return std::move(read->jobs);
}

// What `encode` needs: normals of which none is a unit vector, weights that do not add up to one, feature ids,
// points and faces that it drops, meshes that share grids and one that is there twice.
std::vector<Mesh> every_kind_of_mesh() {
  Mesh odd = make_sheet(20, 20);
  std::vector<float> normals(size_t{3} * odd.point_count, 3.0f);
  std::vector<float> weights(size_t{4} * odd.point_count, 0.2501f);
  odd.attributes[1] = make_attribute("NORMAL", ComponentType::kFloat32, 3, false, normals);
  odd.attributes[5] = make_attribute("WEIGHTS_0", ComponentType::kFloat32, 4, false, weights);
  odd.attributes.back().semantic = "_FEATURE_ID_0";
  Mesh exact = make_sheet(9, 7);
  exact.attributes.back().semantic = "_BATCHID";
  return {make_sheet(60, 50), make_sheet_with_residue(), odd, exact, odd, make_sheet(12, 12),
          make_sheet(11, 12), make_sheet(10, 12)};
}

// The bytes that `encode` writes of all primitives together if it is asked for these patches, and their number.
std::pair<uint64_t, uint64_t> encoded_bytes(Document document, const EncodeDocumentOptions& options) {
  const auto reports = must(encode_document(document, options, draco_backend(), ThreadPool(2)));
  std::pair<uint64_t, uint64_t> sums;
  for (const PrimitiveReport& report : reports) {
    EXPECT_EQ(report.skipped, "");
    if (report.repeated) continue;
    sums.first += report.bytes;
    sums.second += report.streams.size() - (report.has_residue ? 1 : 0);
  }
  return sums;
}

TEST(Comparison, MeasuresTheBytesThatEncodeWrites) {
  const Document document = document_of(every_kind_of_mesh());
  EncodeDocumentOptions lossless, coarse, fast;
  lossless.lossless = true;
  coarse.position_bits = 9;
  coarse.normal_bits = 5;
  coarse.generic_bits = 7;
  fast.encode_speed = 9;
  fast.refine = false;
  for (const EncodeDocumentOptions& coding : {EncodeDocumentOptions(), lossless, coarse, fast}) {
    ComparisonOptions options;
    options.coding = coding;
    options.rules = {{}, {.patches = 1}, {.patches = 9}, {.patches = 40}, {.patch_faces = 500}};
    options.thread_counts = {1};
    options.stock_speeds = {};
    options.rounds.count = 1;
    const std::vector<DecodeBackend> backends{draco_backend()};
    const auto comparison = must(compare_codecs(read_all(document, coding), options, backends, ThreadPool(2)));
    for (size_t i = 0; i < options.rules.size(); ++i) {
      const PatchSummary& summary = comparison.splits[i].summary;
      const auto [bytes, patches] = encoded_bytes(document, apply_rule(coding, options.rules[i]));
      EXPECT_EQ(summary.total_bytes, bytes) << i;
      EXPECT_EQ(summary.patches, patches) << i;
      EXPECT_EQ(summary.faces, comparison.faces) << i;
      EXPECT_EQ(summary.points, comparison.points) << i;
    }
  }
}

TEST(Comparison, SumsOverMeshesAndTimesEveryDecoder) {
  const ThreadPool pool(2);
  const auto meshes = must(generate_shape({Shape::kScene, 12000, 1, true, true}, pool));
  uint64_t faces = 0, points = 0;
  for (const Mesh& mesh : meshes) {
    faces += mesh.faces.size();
    points += mesh.point_count;
  }
  ComparisonOptions options;
  options.rules = {{.patches = 6}, {.patches = 24}};
  options.thread_counts = {1, 2};
  options.rounds.count = 1;
  options.stock_speeds = {10, 0, 10};
  const std::vector<DecodeBackend> backends{draco_backend()};
  size_t done = 0, total = 0;
  const auto comparison =
      compare_codecs(read_all(document_of(meshes), {}), options, backends, pool, [&](size_t now, size_t all) {
        EXPECT_EQ(now, ++done);
        total = all;
      });
  ASSERT_TRUE(comparison.ok()) << comparison.status().to_string();
  // Stock Draco at three speeds, each form of meshoptimizer, and each split with two decoders and in stages.
  EXPECT_EQ(total, 2u * (3 + meshopt_forms().size() + 2 * (2 + 1)));
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
  ASSERT_EQ(comparison->meshopt_brotli.has_value(), !brotli_version().empty());
  if (comparison->meshopt_brotli) {
    EXPECT_LT(comparison->meshopt_brotli->bytes, comparison->meshopt_plain.bytes);
    EXPECT_GT(comparison->meshopt_brotli->decode.median_ms, 0);
  }
}

// A loader decodes the unsplit primitives of an asset in one call, in which the CPU backend takes several
// streams in step. So they must reach the backend as stock streams, and together.
TEST(Comparison, DecodesUnsplitMeshesTogetherAsStockStreams) {
  const ThreadPool pool(1);
  std::vector<Mesh> meshes;
  for (uint32_t i = 0; i < 5; ++i) meshes.push_back(make_sheet(30 + i, 30));
  ComparisonOptions options;
  options.rules = {{.patches = 1}, {.patches = 1, .condense = true}};
  options.thread_counts = {1};
  options.rounds.count = 1;
  std::vector<std::pair<size_t, size_t>> calls;  // tasks, and how many of them are stock streams
  DecodeBackend counting = cpu_backend();
  counting.decode_into = [&](std::span<const DecodeTask> tasks, const BuffersFor& buffers_for,
                             const ThreadPool& threads, const Watch& watch) {
    calls.emplace_back(tasks.size(), std::ranges::count_if(tasks, [](const DecodeTask& task) {
                         return task.container->is_stock;
                       }));
    return cpu_backend().decode_into(tasks, buffers_for, threads, watch);
  };
  const auto comparison =
      must(compare_codecs(read_all(document_of(meshes), {}), options, std::vector{counting}, pool));
  using Calls = std::vector<std::pair<size_t, size_t>>;
  EXPECT_EQ(calls, (Calls{{5, 5}, {5, 0}, {5, 5}, {5, 0}}));
  EXPECT_EQ(comparison.splits[0].summary.directory_bytes, 0u);
  EXPECT_EQ(comparison.splits[0].summary.total_bytes, comparison.stock.bytes);
}

// The system gives memory when it is first written. That is no part of a stage: decoding with memory that was
// used before takes as long as its stages.
TEST(Comparison, StagesAreMeasuredWarm) {
  const ThreadPool pool(1);
  const auto meshes = must(generate_shape({Shape::kBlob, 60000, 1, true, true}, pool));
  ComparisonOptions options;
  options.rules = {{.patches = 1}};
  options.thread_counts = {1};
  options.rounds.count = 7;
  const std::vector<DecodeBackend> backends{cpu_backend()};
  const auto comparison = must(compare_codecs(read_all(document_of(meshes), {}), options, backends, pool, {}));
  double stages_ms = 0;
  for (const StageRow& stage : comparison.splits[0].stages) stages_ms += stage.timing.min_ms;
  EXPECT_LT(stages_ms, 1.5 * comparison.splits[0].decode[0].timing.min_ms);
}

TEST(Comparison, ReportsADecoderThatLosesFaces) {
  const ThreadPool pool(1);
  const auto meshes = must(generate_shape({Shape::kBlob, 2000, 1, false, false}, pool));
  ComparisonOptions options;
  options.rules = {{.patches = 2}};
  options.thread_counts = {1};
  DecodeBackend lossy = draco_backend();
  lossy.decode_into = [](std::span<const DecodeTask> tasks, const BuffersFor& buffers_for, const ThreadPool&,
                         const Watch&) {
    const PatchContainer& container = *tasks.front().container;
    return std::vector<Status>{buffers_for(0, container.point_count(), container.face_count() - 1).status()};
  };
  const auto comparison = compare_codecs(read_all(document_of(meshes), {}), options, std::vector{lossy}, pool);
  ASSERT_FALSE(comparison.ok());
  EXPECT_EQ(comparison.status().code(), StatusCode::kDiffers);
}

}  // namespace
}  // namespace psplit
