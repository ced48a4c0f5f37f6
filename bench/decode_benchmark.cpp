// Decoding on one thread: our CPU backend beside libdraco, the same patches, over Draco's speeds, patch sizes
// and kinds of attributes. --benchmark_enable_random_interleaving=true --benchmark_repetitions=9 measures them
// in turn.
#include <benchmark/benchmark.h>

#include <map>
#include <memory>

#include "bench/sample_meshes.h"
#include "encoder/draco/draco_backend.h"
#include "encoder/encode_mesh.h"
#include "src/cpu/cpu_backend.h"

namespace psplit {
namespace {

struct Sample {
  EncodedMesh encoded;
  std::vector<AttributeRequest> requests;
  uint64_t face_count = 0;
};

// `patch_faces` 0 means one patch.
const Sample& sample(int speed, uint32_t patch_faces, bool all_attributes) {
  static std::map<std::tuple<int, uint32_t, bool>, Sample> samples;
  Sample& sample = samples[{speed, patch_faces, all_attributes}];
  if (sample.face_count > 0) return sample;
  const Mesh mesh = bench_mesh(400'000, all_attributes);
  std::vector<AttributeCoding> codings;
  for (const Attribute& attribute : mesh.attributes) {
    const bool is_normal = attribute.semantic == "NORMAL";
    codings.push_back(is_normal ? AttributeCoding{10, true, {}, 0}
                                : *fit_grid(attribute, attribute.semantic == "POSITION" ? 14 : 12));
  }
  EncodeOptions options;
  options.encode_speed = speed;
  options.patch_count = patch_faces == 0 ? 1 : static_cast<uint32_t>(mesh.faces.size() / patch_faces);
  options.verify = false;
  const ThreadPool pool;
  sample.encoded = std::move(*encode_mesh(mesh, codings, options, pool));
  sample.face_count = mesh.faces.size();
  for (size_t i = 0; i < mesh.attributes.size(); ++i) {
    const Attribute& attribute = mesh.attributes[i];
    sample.requests.push_back({attribute.semantic, sample.encoded.unique_ids[i], attribute.component_type,
                               attribute.component_count, attribute.normalized});
  }
  return sample;
}

void decode(benchmark::State& state, const DecodeBackend& backend, int speed, uint32_t patch_faces,
            bool all_attributes) {
  const Sample& input = sample(speed, patch_faces, all_attributes);
  const ThreadPool pool(1);
  for (auto _ : state) {
    const Expected<Mesh> mesh = backend.decode_container(input.encoded.container, input.requests, pool);
    if (!mesh) state.SkipWithError(mesh.status().to_string().c_str());
    benchmark::DoNotOptimize(mesh);
  }
  state.counters["Mtri/s"] = benchmark::Counter(static_cast<double>(input.face_count) * 1e-6,
                                                benchmark::Counter::kIsIterationInvariantRate);
}

void register_all() {
  for (const bool all_attributes : {false, true}) {
    if (all_attributes && bench_mesh_file() != nullptr) continue;
    for (const uint32_t patch_faces : {4800u, 1200u, 0u})
      for (const int speed : {0, 5, 7, 10})
        for (const DecodeBackend& backend : {cpu_backend(), draco_backend()}) {
          const std::string name = std::string(all_attributes ? "positions+normals+texcoords" : "positions") +
                                   "/" + (patch_faces == 0 ? "whole" : std::to_string(patch_faces)) + "/speed" +
                                   std::to_string(speed) + "/" + backend.name;
          benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
            decode(state, backend, speed, patch_faces, all_attributes);
          })->Unit(benchmark::kMillisecond);
        }
  }
}

}  // namespace
}  // namespace psplit

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  psplit::register_all();
  benchmark::RunSpecifiedBenchmarks();
}
