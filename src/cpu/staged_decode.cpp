#include "src/cpu/staged_decode.h"

#include <algorithm>

#include "src/container/border_values.h"
#include "src/cpu/decode_in_scratch.h"
#include "src/stopwatch.h"

namespace psplit {
namespace {

PSPLIT_OWN_FUNCTION Expected<BorderValues> borders_stage(const PatchContainer& container,
                                                         const ThreadPool& pool, StageTimes& times) {
  const ScopedStopwatch watch(times.chains_ms);
  return BorderValues::decode(container, pool);
}

// Streams that are decoded in step and wait at the same stop.
template <typename Index>
struct AtStop {
  core::PatchDecoder<Index>* const* decoders;
  core::Fault* const* faults;
  uint32_t count;

  void go_on() const { core::take_steps_and_resume(decoders, faults, count); }
};

template <typename Index>
PSPLIT_OWN_FUNCTION core::Fault start_stage(const core::StreamHeader& header, core::Arena& arena,
                                            StreamMemory<Index>& memory, StageTimes& times) {
  const ScopedStopwatch watch(times.connectivity_ms);
  memory.patch = {};
  return memory.decoder.emplace(header, arena, memory.patch).start();
}

template <typename Index>
PSPLIT_OWN_FUNCTION void connectivity_stage(const AtStop<Index>& at, StageTimes& times) {
  const ScopedStopwatch watch(times.connectivity_ms);
  at.go_on();
}

template <typename Index>
PSPLIT_OWN_FUNCTION void seams_stage(const AtStop<Index>& at, StageTimes& times) {
  const ScopedStopwatch watch(times.seams_ms);
  at.go_on();
}

template <typename Index>
PSPLIT_OWN_FUNCTION void chains_stage(const AtStop<Index>& at, StageTimes& times) {
  const ScopedStopwatch watch(times.chains_ms);
  at.go_on();
}

template <typename Index>
PSPLIT_OWN_FUNCTION void prediction_stage(const AtStop<Index>& at, StageTimes& times) {
  const ScopedStopwatch watch(times.prediction_ms);
  at.go_on();
}

// Where the next patch is written.
struct StagedOutput {
  std::array<uint32_t, 3>* faces;
  uint8_t* values;
};

template <typename Index>
PSPLIT_OWN_FUNCTION void output_stage(const core::Patch<Index>& patch, StagedOutput& out, StageTimes& times) {
  const ScopedStopwatch watch(times.output_ms);
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

// Takes memory for `count` streams. Each is large enough for any stream of the container.
template <typename Index>
void allocate(const PatchContainer& container, size_t count, std::span<const AttributeRequest> requests,
              std::vector<StreamMemory<Index>>& streams) {
  size_t size = 0;
  for (uint32_t i = 0; i < container.patch_count(); ++i)
    size = std::max(size, likely_size<Index>(container, i, requests));
  streams.resize(count);
  for (StreamMemory<Index>& stream : streams) stream.arena(size);
}

// Decodes kCount patches in step, as core::decode_in_step does, and measures the stages.
template <uint32_t kCount, typename Index>
core::Fault decode_streams(const PatchContainer& container, const BorderValues& borders, uint32_t first,
                           std::vector<StreamMemory<Index>>& streams, StagedOutput& out, StageTimes& times) {
  core::Arena arenas[kCount];
  core::PatchDecoder<Index>* decoders[kCount];
  core::Fault faults[kCount];
  for (uint32_t n = 0; n < kCount; ++n) {
    StreamMemory<Index>& stream = streams[n];
    arenas[n] = stream.arena(0);
    faults[n] = start_stage(complete_header(container, borders, first + n, stream), arenas[n], stream, times);
    decoders[n] = &*stream.decoder;
  }
  const auto go_on = [&](auto* decoders_at, core::Fault* const* faults_of, uint32_t count) {
    const AtStop<Index> at{decoders_at, faults_of, count};
    switch (at.decoders[0]->stop()) {
      case core::Stop::kSymbolLists:
      case core::Stop::kConnectivity: return connectivity_stage(at, times);
      case core::Stop::kSeams: return seams_stage(at, times);
      case core::Stop::kChains: return chains_stage(at, times);
      case core::Stop::kCorrections:
      case core::Stop::kPrediction: return prediction_stage(at, times);
      case core::Stop::kDone: return;
    }
  };
  core::finish_in_step(decoders, faults, go_on);
  for (uint32_t n = 0; n < kCount; ++n) {
    if (faults[n] != core::Fault::kNone) return faults[n];
    output_stage(streams[n].patch, out, times);
  }
  return core::Fault::kNone;
}

}  // namespace

StagedInput::StagedInput(PatchContainer opened, std::span<const AttributeRequest> requests)
    : container(std::move(opened)) {
  size_t stride = 0;
  for (const AttributeRequest& request : requests) stride += request.value_bytes();
  size_t points = 0;
  for (const StreamEntry& entry : container.entries) points += entry.point_count;
  faces.resize(container.face_count());
  values.resize(stride * points);

  bool fits_16_bits = true;
  for (uint32_t i = 0; i < container.patch_count(); ++i) fits_16_bits &= container.headers[i].fits_16_bits();
  if (fits_16_bits)
    allocate(container, core::kInStep, requests, narrow);
  else
    allocate(container, 1, requests, wide);
}

Status decode_with_core(StagedInput& input, bool in_step, StageTimes& times) {
  const uint32_t count = input.container.patch_count();
  StagedOutput out{input.faces.data(), input.values.data()};
  const Expected<BorderValues> borders = borders_stage(input.container, input.pool, times);
  if (!borders) return borders.status();
  for (uint32_t i = 0; i < count;) {
    const uint32_t together = in_step && input.wide.empty() && i + core::kInStep <= count ? core::kInStep : 1;
    const core::Fault fault =
        !input.wide.empty() ? decode_streams<1>(input.container, *borders, i, input.wide, out, times)
        : together == 1     ? decode_streams<1>(input.container, *borders, i, input.narrow, out, times)
                        : decode_streams<core::kInStep>(input.container, *borders, i, input.narrow, out, times);
    if (fault != core::Fault::kNone) return status_of(fault);
    i += together;
  }
  return {};
}

}  // namespace psplit
