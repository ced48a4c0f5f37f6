// Measures the time of each stage of decoding: a container's patches on one thread, with the core's decoder as
// src/cpu drives it. It does not stitch; its output is one patch after the other.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "psplit/base.h"
#include "psplit/decode.h"
#include "psplit/parallel.h"
#include "src/container/patch_container.h"
#include "src/cpu/scratch.h"

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

// A container, the memory to decode its streams, and the memory for its mesh without the residue. The container
// must hold the attributes as they are requested.
struct StagedInput {
  StagedInput(PatchContainer opened, std::span<const AttributeRequest> requests);

  PatchContainer container;
  std::vector<std::array<uint32_t, 3>> faces;
  std::vector<uint8_t> values;
  std::vector<StreamMemory<uint16_t>> narrow;  // empty if a stream is too large for 16-bit numbers
  std::vector<StreamMemory<uint32_t>> wide;
  ThreadPool pool{1};
};

// Decodes all patches one after the other or, with `in_step`, as many at a time as src/cpu does and the rest
// alone. Errors: as for the core.
Status decode_with_core(StagedInput& input, bool in_step, StageTimes& times);

}  // namespace psplit
