// The stages of decoding on one thread: psplit's core and libdraco, with the same patches. The counters are
// milliseconds of each stage.
//
//   stage_benchmark [--benchmark_...]           measures
//   stage_benchmark --write SAMPLE FILE         writes the container of a sample for the next two
//   stage_benchmark --count DECODER FILE        decodes it once; bench/count_instructions runs this
//   stage_benchmark --peak DECODER FILE         does the same, and prints the peak of memory in megabytes
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <fstream>
#include <iterator>

#include "bench/draco_stages.h"
#include "bench/samples.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "src/cpu/staged_decode.h"

namespace psplit {
namespace {

bool decode_with_draco(StagedInput& input, DracoTimes& times) {
  for (uint32_t i = 0; i < input.container.patch_count(); ++i) {
    draco::Mesh mesh;
    if (!DracoStages(times).decode(input.container.streams[i], mesh)) return false;
  }
  return true;
}

// Milliseconds per iteration; zero if a decoder does not time its stages.
void report(benchmark::State& state, const StageTimes& ours, const DracoTimes& draco) {
  const auto count = [&](const char* stage, double sum_ms) {
    state.counters[stage] = benchmark::Counter(sum_ms, benchmark::Counter::kAvgIterations);
  };
  count("1 connectivity", ours.connectivity_ms + draco.connectivity_ms);
  count("2 seams", ours.seams_ms);
  count("3 traversal, symbols", ours.chains_ms);
  count("4 prediction", ours.prediction_ms);
  count("5 output", ours.output_ms);
  count("3-5 attributes", draco.attributes_ms);
}

void measure_core(benchmark::State& state, const SampleKind& kind, bool in_step) {
  const Sample& from = sample(kind);
  StagedInput input(*open_container(from.container), from.requests);
  StageTimes times;
  for (auto _ : state) {
    const Status status = decode_with_core(input, in_step, times);
    if (!status.ok()) state.SkipWithError(status.message().c_str());
    benchmark::ClobberMemory();
  }
  report(state, times, {});
}

void measure_draco(benchmark::State& state, const SampleKind& kind) {
  const Sample& from = sample(kind);
  StagedInput input(*open_container(from.container), from.requests);
  DracoTimes times;
  for (auto _ : state)
    if (!decode_with_draco(input, times)) state.SkipWithError("libdraco cannot decode it");
  report(state, {}, times);
}

void register_all() {
  const auto add = [](const std::string& name, auto measure) {
    benchmark::RegisterBenchmark(name.c_str(), measure)->Unit(benchmark::kMillisecond)->UseRealTime();
  };
  for (const SampleKind& kind : sample_kinds()) {
    add(kind.name() + "/core", [=](benchmark::State& state) { measure_core(state, kind, false); });
    if (kind.patch_faces > 0)
      add(kind.name() + "/core_in_step", [=](benchmark::State& state) { measure_core(state, kind, true); });
    if (kind.condensed) continue;  // libdraco decodes expanded streams only
    add(kind.name() + "/draco", [=](benchmark::State& state) { measure_draco(state, kind); });
  }
}

// The file format of a sample: the number of its attributes, the id and components of each, the container.
void write_sample(const std::string& name, const char* path) {
  for (const SampleKind& kind : sample_kinds()) {
    if (kind.name() != name) continue;
    const Sample& from = sample(kind);
    std::ofstream file(path, std::ios::binary);
    file.put(static_cast<char>(from.requests.size()));
    for (const AttributeRequest& request : from.requests)
      file.put(static_cast<char>(request.unique_id)).put(static_cast<char>(request.component_count));
    file.write(reinterpret_cast<const char*>(from.container.data()),
               static_cast<std::streamsize>(from.container.size()));
    if (!file.flush()) give_up(io_failure(std::string(path) + ": cannot be written"));
    return;
  }
  give_up(invalid_input("no sample is called " + name));
}

Sample read_sample(const char* path) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  if (bytes.empty()) give_up(io_failure(std::string(path) + ": cannot be read"));
  Sample sample;
  auto at = bytes.begin() + 1;
  for (char i = 0; i < bytes[0]; ++i, at += 2)
    sample.requests.push_back({"_" + std::to_string(i), static_cast<uint32_t>(at[0]), ComponentType::kFloat32,
                               static_cast<uint8_t>(at[1]), false});
  sample.container.assign(at, bytes.end());
  return sample;
}

// Exactly the code whose instructions are counted.
PSPLIT_OWN_FUNCTION bool counted_decode(const std::string& decoder, const Sample& from, StagedInput& input,
                                        const ThreadPool& pool) {
  for (const DecodeBackend& backend : {cpu_backend(), draco_backend()})
    if (decoder == backend.name)
      return backend.decode(*open_container(from.container), from.requests, pool).ok();
  StageTimes times;
  return decode_with_core(input, decoder == "core_in_step", times).ok();
}

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

void decode_once(const std::string& decoder, const char* path, bool peak) {
  const Sample from = read_sample(path);
  StagedInput input(*open_container(from.container), from.requests);
  const ThreadPool pool(1);
  const double before = peak_megabytes();
  if (!counted_decode(decoder, from, input, pool)) give_up(invalid_input(decoder + " cannot decode " + path));
  if (peak)
    std::printf("%.1f\n", peak_megabytes() - before);
  else
    std::printf("%u\n", input.container.face_count());
}

}  // namespace
}  // namespace psplit

int main(int argc, char** argv) {
  const std::string mode = argc == 4 ? argv[1] : "";
  if (mode == "--write") return psplit::write_sample(argv[2], argv[3]), 0;
  if (mode == "--count" || mode == "--peak") return psplit::decode_once(argv[2], argv[3], mode == "--peak"), 0;
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  psplit::register_all();
  benchmark::RunSpecifiedBenchmarks();
}
