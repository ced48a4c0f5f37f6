// Measures the time of each stage of decoding: a container's patches on one thread, with the core's decoder as
// src/cpu drives it. It does not stitch; its output is one patch after the other.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "src/container/border_values.h"
#include "src/container/patch_container.h"
#include "src/cpu/decode_in_scratch.h"
#include "src/stopwatch.h"

// Keeps a function visible to profilers: bench/count_instructions reads the names of these functions.
#define PSPLIT_OWN_FUNCTION [[gnu::noinline]]

namespace psplit {

struct StageTimes {
  double connectivity_ms = 0;  // from the header to the corner table, preparation of memory included
  double seams_ms = 0;         // to points. A traversal by prediction degree counts here or above
  double chains_ms = 0;        // traversal and symbols, and the values that patches share at their borders
  double prediction_ms = 0;
  double output_ms = 0;  // faces to 32-bit indices, integers to values
};

// The state of one stream while it is decoded. Its memory is large enough for any stream of the container.
template <typename Index>
class StreamDecoder {
 public:
  StreamDecoder(const PatchContainer& container, std::span<const AttributeRequest> requests) {
    for (uint32_t i = 0; i < container.patch_count(); ++i)
      size_ = std::max(size_, likely_size<Index>(container, i, requests));
    memory_.reset(new uint8_t[size_]);
  }

  void begin(const core::StreamHeader& header) {
    arena_ = {memory_.get(), size_};
    patch_ = {};
    header_ = header;
    decoder_.emplace(header_, arena_, patch_);
  }
  core::PatchDecoder<Index>& decoder() { return *decoder_; }
  const core::Patch<Index>& patch() const { return patch_; }

 private:
  std::unique_ptr<uint8_t[]> memory_;
  size_t size_ = 0;
  core::Arena arena_;
  core::StreamHeader header_;
  core::Patch<Index> patch_;
  std::optional<core::PatchDecoder<Index>> decoder_;
};

PSPLIT_OWN_FUNCTION inline Expected<BorderValues> borders_stage(const PatchContainer& container,
                                                                const ThreadPool& pool, StageTimes& times) {
  const ScopedStopwatch watch(times.chains_ms);
  return BorderValues::decode(container, pool);
}

// Streams that are decoded in step and wait at the same stop.
template <typename Index>
struct AtStop {
  core::PatchDecoder<Index>* decoders[core::kInStep];
  core::Fault* faults[core::kInStep];
  uint32_t count = 0;

  void go_on() {
    core::take_steps(decoders, count);
    for (uint32_t n = 0; n < count; ++n) *faults[n] = decoders[n]->resume(core::SerialLanes());
  }
};

template <typename Index>
PSPLIT_OWN_FUNCTION core::Fault start_stage(const core::StreamHeader& header, StreamDecoder<Index>& decoder,
                                            StageTimes& times) {
  const ScopedStopwatch watch(times.connectivity_ms);
  decoder.begin(header);
  return decoder.decoder().start();
}

template <typename Index>
PSPLIT_OWN_FUNCTION void connectivity_stage(AtStop<Index>& at, StageTimes& times) {
  const ScopedStopwatch watch(times.connectivity_ms);
  at.go_on();
}

template <typename Index>
PSPLIT_OWN_FUNCTION void seams_stage(AtStop<Index>& at, StageTimes& times) {
  const ScopedStopwatch watch(times.seams_ms);
  at.go_on();
}

template <typename Index>
PSPLIT_OWN_FUNCTION void chains_stage(AtStop<Index>& at, StageTimes& times) {
  const ScopedStopwatch watch(times.chains_ms);
  at.go_on();
}

template <typename Index>
PSPLIT_OWN_FUNCTION void prediction_stage(AtStop<Index>& at, StageTimes& times) {
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

// A container, the memory to decode its streams, and the memory for its mesh without the residue. The container
// must hold the attributes as they are requested.
struct StagedInput {
  StagedInput(PatchContainer opened, std::span<const AttributeRequest> requests)
      : container(std::move(opened)) {
    size_t stride = 0;
    for (const AttributeRequest& request : requests) stride += request.value_bytes();
    size_t points = 0;
    for (const StreamEntry& entry : container.entries) points += entry.point_count;
    faces.resize(container.face_count());
    values.resize(stride * points);

    bool fits_16_bits = true;
    for (uint32_t i = 0; i < container.patch_count(); ++i) fits_16_bits &= container.headers[i].fits_16_bits();
    if (!fits_16_bits) wide.emplace_back(container, requests);
    for (uint32_t n = 0; n < core::kInStep && fits_16_bits; ++n) narrow.emplace_back(container, requests);
  }

  PatchContainer container;
  std::vector<std::array<uint32_t, 3>> faces;
  std::vector<uint8_t> values;
  std::vector<StreamDecoder<uint16_t>> narrow;  // empty if a stream is too large for 16-bit numbers
  std::vector<StreamDecoder<uint32_t>> wide;
  ThreadPool pool{1};
};

// Decodes `count` patches in step, as core::decode_in_step does, and measures the stages.
template <typename Index>
core::Fault decode_streams(const PatchContainer& container, const BorderValues& borders, uint32_t first,
                           uint32_t count, std::vector<StreamDecoder<Index>>& decoders, StagedOutput& out,
                           StageTimes& times) {
  core::Fault faults[core::kInStep];
  for (uint32_t n = 0; n < count; ++n) {
    core::StreamHeader header = container.headers[first + n];
    borders.complete(first + n, header);
    faults[n] = start_stage(header, decoders[n], times);
  }
  for (;;) {
    AtStop<Index> at;
    for (uint32_t n = 0; n < count; ++n) {
      core::PatchDecoder<Index>& decoder = decoders[n].decoder();
      if (faults[n] != core::Fault::kNone || decoder.stop() == core::Stop::kDone) continue;
      if (at.count > 0 && decoder.stop() != at.decoders[0]->stop()) continue;
      at.decoders[at.count] = &decoder;
      at.faults[at.count++] = &faults[n];
    }
    if (at.count == 0) break;
    switch (at.decoders[0]->stop()) {
      case core::Stop::kSymbolLists:
      case core::Stop::kConnectivity: connectivity_stage(at, times); break;
      case core::Stop::kSeams: seams_stage(at, times); break;
      case core::Stop::kChains: chains_stage(at, times); break;
      case core::Stop::kCorrections:
      case core::Stop::kPrediction: prediction_stage(at, times); break;
      case core::Stop::kDone: break;
    }
  }
  for (uint32_t n = 0; n < count; ++n) {
    if (faults[n] != core::Fault::kNone) return faults[n];
    output_stage(decoders[n].patch(), out, times);
  }
  return core::Fault::kNone;
}

// Decodes all patches one after the other or, with `in_step`, as many at a time as src/cpu does and the rest
// alone. Errors: those of the core.
inline Status decode_with_core(StagedInput& input, bool in_step, StageTimes& times) {
  const uint32_t count = input.container.patch_count();
  StagedOutput out{input.faces.data(), input.values.data()};
  const Expected<BorderValues> borders = borders_stage(input.container, input.pool, times);
  if (!borders) return borders.status();
  for (uint32_t i = 0; i < count;) {
    const uint32_t together = in_step && i + core::kInStep <= count ? core::kInStep : 1;
    const core::Fault fault =
        !input.wide.empty() ? decode_streams(input.container, *borders, i, 1, input.wide, out, times)
                            : decode_streams(input.container, *borders, i, together, input.narrow, out, times);
    if (fault != core::Fault::kNone) return status_of(fault);
    i += input.wide.empty() ? together : 1;
  }
  return {};
}

}  // namespace psplit
