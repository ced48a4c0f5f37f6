// Encodes a mesh: as one Edgebreaker stream by psplit's encoder and by libdraco's, which write the same bytes,
// and in patches, which are cut, encoded, stitched and verified. All get the mesh that a stream decodes to, so
// in the same order; libdraco gets it as its own mesh. Its points become clouds, again of the same bytes.
// --benchmark_enable_random_interleaving=true
// --benchmark_repetitions=9 interleaves them.
#include <benchmark/benchmark.h>

#include <optional>

#include "bench/draco_encoder.h"
#include "bench/samples.h"
#include "encoder/coding/quantization.h"
#include "encoder/stream/cloud_stream.h"
#include "encoder/stream/encode_stream.h"
#include "system/operating_system.h"

namespace psplit {
namespace {

struct Input {
  Mesh mesh;
  WeldedMesh welded;
  PatchMesh whole;
  std::vector<AttributeCoding> codings;
  Mesh cloud;
  std::vector<AttributeCoding> cloud_codings;
  std::optional<DracoEncoder> libdraco;
};

const Input& input(bool all_attributes) {
  static Input inputs[2];
  Input& made = inputs[all_attributes];
  if (made.libdraco) return made;
  const ThreadPool pool;
  const Mesh given = bench_mesh(400'000, all_attributes);
  const std::vector<AttributeCoding> codings = bench_codings(given);
  constexpr int kSpeed = 5;
  const Expected<EncodedPatch> stream =
      encode_stream(weld(given, pool), whole_mesh(given), codings, kSpeed, true);
  if (!stream) give_up(stream.status());
  made.mesh = stream->decoded;
  made.welded = weld(made.mesh, pool);
  made.whole = whole_mesh(made.mesh);
  made.codings = bench_codings(made.mesh);
  Expected<DracoEncoder> libdraco = DracoEncoder::of(stream->bytes);
  if (!libdraco) give_up(libdraco.status());
  made.libdraco = std::move(*libdraco);
  made.cloud = {made.mesh.point_count, {}, made.mesh.attributes};
  for (const Attribute& attribute : made.cloud.attributes) {
    Expected<AttributeCoding> grid = fit_grid(attribute, made.codings[made.cloud_codings.size()].bits);
    if (!grid) give_up(grid.status());
    made.cloud_codings.push_back(std::move(*grid));
  }
  return made;
}

void count_triangles(benchmark::State& state, const Mesh& mesh) {
  state.counters["Mtri/s"] = benchmark::Counter(static_cast<double>(mesh.faces.size()) * 1e-6,
                                                benchmark::Counter::kIsIterationInvariantRate);
}

void count_points(benchmark::State& state, const Mesh& cloud) {
  state.counters["Mpoints/s"] = benchmark::Counter(static_cast<double>(cloud.point_count) * 1e-6,
                                                   benchmark::Counter::kIsIterationInvariantRate);
}

// Measures `encode`, which returns an Expected.
template <typename Encode>
void measure(benchmark::State& state, Encode encode) {
  for (auto _ : state) {
    const auto encoded = encode();
    if (!encoded) state.SkipWithError(encoded.status().to_string().c_str());
    benchmark::DoNotOptimize(encoded);
  }
}

void encode_by_draco(benchmark::State& state, bool all_attributes, int speed) {
  const Input& given = input(all_attributes);
  measure(state, [&] { return given.libdraco->encode(speed); });
  count_triangles(state, given.mesh);
}

void encode_one_stream(benchmark::State& state, bool all_attributes, int speed) {
  const Input& given = input(all_attributes);
  measure(state, [&] { return encode_stream(given.welded, given.whole, given.codings, speed); });
  count_triangles(state, given.mesh);
}

void encode_cloud_by_draco(benchmark::State& state, bool all_attributes, int speed) {
  const Input& given = input(all_attributes);
  measure(state, [&] { return given.libdraco->encode_points(speed); });
  count_points(state, given.cloud);
}

void encode_cloud_by_psplit(benchmark::State& state, bool all_attributes, int speed) {
  const Input& given = input(all_attributes);
  const bool is_tree = becomes_tree(given.cloud, given.cloud_codings, speed);
  measure(state, [&] {
    return encode_cloud(given.cloud, is_tree ? given.cloud_codings : given.codings, is_tree, speed);
  });
  count_points(state, given.cloud);
}

void encode_patches(benchmark::State& state, bool all_attributes, int speed, int thread_count) {
  const Input& given = input(all_attributes);
  const ThreadPool pool(thread_count);
  StreamOptions options;
  options.encode_speed = speed;
  options.patch_count = static_cast<uint32_t>(given.mesh.faces.size() / 4800);
  measure(state, [&] { return encode_mesh(given.mesh, given.codings, options, pool); });
  count_triangles(state, given.mesh);
}

void register_all() {
  const auto add = [](const std::string& name, auto work) {
    benchmark::RegisterBenchmark(name.c_str(), work)->Unit(benchmark::kMillisecond)->UseRealTime();
  };
  for (const bool all_attributes : {false, true})
    for (const int speed : {0, 5, 7, 9, 10}) {
      const std::string name = std::string("encode/cloud/") +
                               (all_attributes ? "positions+normals+texcoords" : "positions") + "/speed" +
                               std::to_string(speed);
      add(name + "/draco",
          [=](benchmark::State& state) { encode_cloud_by_draco(state, all_attributes, speed); });
      add(name + "/stream",
          [=](benchmark::State& state) { encode_cloud_by_psplit(state, all_attributes, speed); });
    }
  const int all = ThreadPool().thread_count();
  for (const bool all_attributes : {false, true})
    for (const int speed : {0, 5, 10}) {
      const std::string name = std::string("encode/") +
                               (all_attributes ? "positions+normals+texcoords" : "positions") + "/speed" +
                               std::to_string(speed);
      add(name + "/draco", [=](benchmark::State& state) { encode_by_draco(state, all_attributes, speed); });
      add(name + "/stream", [=](benchmark::State& state) { encode_one_stream(state, all_attributes, speed); });
      for (int thread_count = 1;; thread_count = all) {
        add(name + "/patches/threads:" + std::to_string(thread_count),
            [=](benchmark::State& state) { encode_patches(state, all_attributes, speed, thread_count); });
        if (thread_count == all) break;
      }
    }
}

}  // namespace
}  // namespace psplit

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  psplit::expect_large_arrays();  // as the command `encode`; both encoders gain
  psplit::register_all();
  benchmark::RunSpecifiedBenchmarks();
}
