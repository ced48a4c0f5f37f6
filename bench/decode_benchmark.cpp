// Decodes whole containers to meshes: psplit's CPU backend and libdraco, with the same patches, on one thread
// and on all. --benchmark_enable_random_interleaving=true --benchmark_repetitions=9 interleaves them.
#include <benchmark/benchmark.h>

#include "bench/samples.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "src/container/patch_container.h"

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
  state.counters["Mtri/s"] = benchmark::Counter(static_cast<double>(input.face_count) * 1e-6,
                                                benchmark::Counter::kIsIterationInvariantRate);
}

void register_all() {
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
