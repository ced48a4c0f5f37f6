// Decodes whole containers to meshes: psplit's CPU backend and libdraco, with the same patches, on one thread
// and on all; and meshoptimizer the whole mesh, on the same grids, alone, with zstd and with brotli.
// --benchmark_enable_random_interleaving=true --benchmark_repetitions=9 interleaves them.
#include <benchmark/benchmark.h>

#include "bench/samples.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "src/container/patch_container.h"
#include "tools/gltf_psplit/compare/meshopt_rival.h"

namespace psplit {
namespace {

void decode(benchmark::State& state, const DecodeBackend& backend, const SampleKind& kind, int thread_count) {
  const Sample& input = sample(kind);
  const ThreadPool pool(thread_count);
  for (auto _ : state) {
    const Expected<Mesh> mesh = backend.decode(*open_container(input.container), input.requests, pool);
    if (!mesh) state.SkipWithError(mesh.status().to_string().c_str());
    benchmark::DoNotOptimize(mesh);
  }
  state.counters["bytes"] = static_cast<double>(input.container.size());
  state.counters["Mtri/s"] = benchmark::Counter(static_cast<double>(input.face_count) * 1e-6,
                                                benchmark::Counter::kIsIterationInvariantRate);
}

const MeshoptMesh& meshopt_sample(bool all_attributes) {
  static std::map<bool, MeshoptMesh> samples;
  const auto [at, is_new] = samples.try_emplace(all_attributes);
  if (is_new) {
    const Mesh mesh = bench_mesh(400'000, all_attributes);
    Expected<MeshoptMesh> encoded = encode_meshopt(mesh, bench_codings(mesh));
    if (!encoded) give_up(encoded.status());
    at->second = std::move(*encoded);
  }
  return at->second;
}

void decode_meshopt_sample(benchmark::State& state, bool all_attributes, MeshoptForm form) {
  const MeshoptMesh& mesh = meshopt_sample(all_attributes);
  state.SetLabel(meshopt_version() + ", codec " + std::to_string(meshopt_codec_version()));
  for (auto _ : state) {
    const auto decoded = decode_meshopt(mesh, form);
    if (!decoded) state.SkipWithError(decoded.status().to_string().c_str());
    benchmark::DoNotOptimize(decoded);
  }
  state.counters["bytes"] = static_cast<double>(mesh.bytes(form).size());
  state.counters["Mtri/s"] = benchmark::Counter(static_cast<double>(mesh.index_count) / 3e6,
                                                benchmark::Counter::kIsIterationInvariantRate);
}

void register_all() {
  for (const bool all_attributes : {false, true})
    for (const MeshoptForm form : meshopt_forms()) {
      const std::string name = SampleKind{.all_attributes = all_attributes}.attributes() + "/meshopt" +
                               (form == MeshoptForm::kZstd     ? "+zstd"
                                : form == MeshoptForm::kBrotli ? "+brotli"
                                                               : "");
      benchmark::RegisterBenchmark(
          name.c_str(), [=](benchmark::State& state) { decode_meshopt_sample(state, all_attributes, form); })
          ->Unit(benchmark::kMillisecond)
          ->UseRealTime();
    }
  const int all = ThreadPool().thread_count();
  for (const SampleKind& kind : sample_kinds())
    for (int thread_count = 1;; thread_count = all) {
      for (const DecodeBackend& backend : {cpu_backend(), draco_backend()}) {
        if (kind.condensed && backend.name == draco_backend().name) continue;  // it would time the expansion
        const std::string name = kind.name() + "/" + backend.name + "/threads:" + std::to_string(thread_count);
        benchmark::RegisterBenchmark(
            name.c_str(), [=](benchmark::State& state) { decode(state, backend, kind, thread_count); })
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime();
      }
      // With a single patch, a second thread has no work.
      if (thread_count == all || kind.patch_faces == 0) break;
    }
}

}  // namespace
}  // namespace psplit

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  psplit::register_all();
  benchmark::RunSpecifiedBenchmarks();
}
