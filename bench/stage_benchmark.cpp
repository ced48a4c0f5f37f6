// The stages of decoding, one thread: our core beside libdraco, the same patches. Counters are milliseconds of
// each stage.
//
//   stage_benchmark [--benchmark_...]           measures
//   stage_benchmark --write SAMPLE FILE         writes the container of a sample, for:
//   stage_benchmark --count DECODER FILE        decodes it once: what bench/count_instructions runs
//   stage_benchmark --peak DECODER FILE         the same, and says how many megabytes that took at most
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <fstream>
#include <iterator>
#include <memory>
#include <optional>

#include "bench/draco_stages.h"
#include "bench/samples.h"
#include "bench/stopwatch.h"
#include "encoder/draco/draco_backend.h"
#include "src/container/container.h"
#include "src/core/decode_patch.h"
#include "src/cpu/cpu_backend.h"
#include "src/cpu/scratch.h"

// Of what profilers are to tell apart: bench/count_instructions reads these names.
#define PSPLIT_OWN_FUNCTION [[gnu::noinline]]

namespace psplit {
namespace {

using core::Fault;
using core::Stop;

struct StageTimes {
  double connectivity_ms = 0;  // header to corner table, and memory made ready
  double seams_ms = 0;         // to points; by prediction degree the traversal as well, here or above
  double chains_ms = 0;        // traversal and symbols
  double prediction_ms = 0;
  double output_ms = 0;  // faces to 32-bit indices, integers to values
};

// A stream while it is decoded, in memory for any of a container.
template <typename Index>
class StreamDecoder {
 public:
  explicit StreamDecoder(const Container& container) {
    for (uint32_t i = 0; i < container.patch_count(); ++i) {
      const StreamEntry& entry = container.entries[i];
      size_ = std::max(size_, size_t{256} * (entry.face_count + entry.point_count) + 2 * entry.stream_bytes);
    }
    size_ += size_t{1} << 17;
    memory_ = std::make_unique_for_overwrite<uint8_t[]>(size_);
  }

  Fault open(std::span<const uint8_t> stream) {
    header_ = {};
    if (const Fault fault = core::read_stream_header(stream.data(), stream.size(), header_);
        fault != Fault::kNone)
      return fault;
    arena_ = {memory_.get(), size_};
    patch_ = {};
    decoder_.emplace(header_, arena_, patch_);
    return Fault::kNone;
  }
  core::PatchDecoder<Index>& decoder() { return *decoder_; }
  const core::Patch<Index>& patch() const { return patch_; }

 private:
  std::unique_ptr<uint8_t[]> memory_;
  size_t size_ = 0;
  core::StreamHeader header_;
  core::Arena arena_;
  core::Patch<Index> patch_;
  std::optional<core::PatchDecoder<Index>> decoder_;
};

// Streams that are decoded in step, as far as they stand at the same stop.
template <typename Index>
struct AtStop {
  core::PatchDecoder<Index>* decoders[kLanes];
  Fault* faults[kLanes];
  uint32_t count = 0;

  void go_on() {
    core::take_steps(decoders, count);
    for (uint32_t n = 0; n < count; ++n) *faults[n] = decoders[n]->resume(core::SerialLanes());
  }
};

template <typename Index>
PSPLIT_OWN_FUNCTION Fault start_stage(std::span<const uint8_t> stream, StreamDecoder<Index>& lane,
                                      StageTimes& times) {
  const Stopwatch watch(times.connectivity_ms);
  const Fault fault = lane.open(stream);
  return fault == Fault::kNone ? lane.decoder().start() : fault;
}

template <typename Index>
PSPLIT_OWN_FUNCTION void connectivity_stage(AtStop<Index>& at, StageTimes& times) {
  const Stopwatch watch(times.connectivity_ms);
  at.go_on();
}

template <typename Index>
PSPLIT_OWN_FUNCTION void seams_stage(AtStop<Index>& at, StageTimes& times) {
  const Stopwatch watch(times.seams_ms);
  at.go_on();
}

template <typename Index>
PSPLIT_OWN_FUNCTION void chains_stage(AtStop<Index>& at, StageTimes& times) {
  const Stopwatch watch(times.chains_ms);
  at.go_on();
}

template <typename Index>
PSPLIT_OWN_FUNCTION void prediction_stage(AtStop<Index>& at, StageTimes& times) {
  const Stopwatch watch(times.prediction_ms);
  at.go_on();
}

// Where the next patch goes.
struct Output {
  std::array<uint32_t, 3>* faces;
  uint8_t* values;
};

template <typename Index>
PSPLIT_OWN_FUNCTION void output_stage(const core::Patch<Index>& patch, Output& out, StageTimes& times) {
  const Stopwatch watch(times.output_ms);
  std::array<uint32_t, 3>* const faces = out.faces;
  for (uint32_t face = 0; face < patch.face_count; ++face)
    faces[face] = {patch.point_at[4 * face], patch.point_at[4 * face + 1], patch.point_at[4 * face + 2]};
  out.faces += patch.face_count;
  for (uint32_t i = 0; i < patch.attributes.size(); ++i) {
    const core::Attribute<Index>& attribute = patch.attributes[i];
    const size_t stride = attribute.stride();
    patch.write_values(attribute,
                       [stride, values = out.values](uint32_t point) { return values + point * stride; });
    out.values += patch.point_count * stride;
  }
}

// A container, memory to decode its streams in, and room for its mesh. Its residue, which is no Edgebreaker
// stream, is left out.
struct Input {
  explicit Input(const Sample& from) : container(*parse_container(from.container)) {
    size_t stride = 0;
    for (const AttributeRequest& request : from.requests)
      stride += component_bytes(request.component_type) * request.component_count;
    size_t points = 0;
    for (const StreamEntry& entry : container.entries) points += entry.point_count;
    faces.resize(container.face_count());
    values.resize(stride * points);

    bool fits_16_bits = true;
    for (uint32_t i = 0; i < container.patch_count(); ++i) {
      core::StreamHeader header;
      const std::span<const uint8_t> stream = container.streams[i];
      fits_16_bits &= core::read_stream_header(stream.data(), stream.size(), header) == Fault::kNone &&
                      header.fits_16_bits();
    }
    if (!fits_16_bits) wide.emplace_back(container);
    for (uint32_t n = 0; n < kLanes && fits_16_bits; ++n) narrow.emplace_back(container);
  }

  Container container;
  std::vector<std::array<uint32_t, 3>> faces;
  std::vector<uint8_t> values;
  std::vector<StreamDecoder<uint16_t>> narrow;  // none where a stream is too large for 16-bit numbers
  std::vector<StreamDecoder<uint32_t>> wide;
};

// `count` streams in step: core::decode_in_step with a watch.
template <typename Index>
Fault decode_streams(const std::span<const uint8_t>* streams, std::vector<StreamDecoder<Index>>& lanes,
                     uint32_t count, Output& out, StageTimes& times) {
  Fault faults[kLanes];
  for (uint32_t n = 0; n < count; ++n) faults[n] = start_stage(streams[n], lanes[n], times);
  for (;;) {
    AtStop<Index> at;
    for (uint32_t n = 0; n < count; ++n) {
      core::PatchDecoder<Index>& decoder = lanes[n].decoder();
      if (faults[n] != Fault::kNone || decoder.stop() == Stop::kDone) continue;
      if (at.count > 0 && decoder.stop() != at.decoders[0]->stop()) continue;
      at.decoders[at.count] = &decoder;
      at.faults[at.count++] = &faults[n];
    }
    if (at.count == 0) break;
    switch (at.decoders[0]->stop()) {
      case Stop::kSymbolLists: connectivity_stage(at, times); break;
      case Stop::kSeams: seams_stage(at, times); break;
      case Stop::kChains: chains_stage(at, times); break;
      case Stop::kPrediction: prediction_stage(at, times); break;
      case Stop::kDone: break;
    }
  }
  for (uint32_t n = 0; n < count; ++n) {
    if (faults[n] != Fault::kNone) return faults[n];
    output_stage(lanes[n].patch(), out, times);
  }
  return Fault::kNone;
}

// One stream after the other; or, `in_step`, as many at once as src/cpu takes, and those left at the end alone.
Fault decode_with_core(Input& input, bool in_step, StageTimes& times) {
  const uint32_t count = input.container.patch_count();
  Output out{input.faces.data(), input.values.data()};
  for (uint32_t i = 0; i < count;) {
    const std::span<const uint8_t>* streams = &input.container.streams[i];
    const uint32_t together = in_step && i + kLanes <= count ? kLanes : 1;
    const Fault fault = !input.wide.empty() ? decode_streams(streams, input.wide, 1, out, times)
                                            : decode_streams(streams, input.narrow, together, out, times);
    if (fault != Fault::kNone) return fault;
    i += input.wide.empty() ? together : 1;
  }
  return Fault::kNone;
}

bool decode_with_draco(Input& input, DracoTimes& times) {
  for (uint32_t i = 0; i < input.container.patch_count(); ++i) {
    draco::Mesh mesh;
    if (!DracoStages(times).decode(input.container.streams[i], mesh)) return false;
  }
  return true;
}

// Milliseconds an iteration; zero where a decoder does not tell stages apart.
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
  Input input(sample(kind));
  StageTimes times;
  for (auto _ : state) {
    const Fault fault = decode_with_core(input, in_step, times);
    if (fault != Fault::kNone) state.SkipWithError(core::fault_text(fault));
    benchmark::ClobberMemory();
  }
  report(state, times, {});
}

void measure_draco(benchmark::State& state, const SampleKind& kind) {
  Input input(sample(kind));
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
    add(kind.name() + "/draco", [=](benchmark::State& state) { measure_draco(state, kind); });
  }
}

// A sample as a file: the number of its attributes, each one's id and components, the container.
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

// All of what is counted, and nothing else.
PSPLIT_OWN_FUNCTION bool counted_decode(const std::string& decoder, const Sample& from, Input& input,
                                        const ThreadPool& pool) {
  for (const DecodeBackend& backend : {cpu_backend(), draco_backend()})
    if (decoder == backend.name) return backend.decode_container(from.container, from.requests, pool).ok();
  StageTimes times;
  return decode_with_core(input, decoder == "core_in_step", times) == Fault::kNone;
}

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

void decode_once(const std::string& decoder, const char* path, bool peak) {
  const Sample from = read_sample(path);
  Input input(from);
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
