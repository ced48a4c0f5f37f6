// Expands condensed streams (src/core/condensed/condensed_stream.h) to the Draco streams that they were made
// from, bit for bit.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/fields/section_bytes.h"
#include "src/container/condensed_head.h"

namespace psplit {

// A condensed stream, and what its row says about it.
struct CondensedPatch {
  std::span<const uint8_t> bytes;
  uint32_t skeleton = 0;  // its number in the head
  uint32_t face_count = 0, point_count = 0;
  // The values of the first attribute at the places of the stream's border walk, one component after the other,
  // if CondensedHead::has_borders.
  std::span<const int32_t> known{};
};

// The bytes of a condensed stream by section, which sum to its size. Errors: as for expand_stream.
Expected<SectionBytes> measure_stream(const CondensedHead& head, const CondensedPatch& patch);

// The Draco stream of a condensed patch. The patch may be hostile. Errors: kInvalidInput. Thread-safe.
Expected<std::vector<uint8_t>> expand_stream(const CondensedHead& head, const CondensedPatch& patch);

}  // namespace psplit
