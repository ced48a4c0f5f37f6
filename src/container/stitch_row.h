// One stream's part of the stitch map, as the core's readers take it.
#pragma once

#include "src/container/container.h"
#include "src/core/stitch_reader.h"

namespace psplit {

inline core::StitchRow stitch_row(const Container& container, uint32_t patch) {
  const std::span<const uint8_t> bytes = container.stitch[patch];
  const StreamEntry& entry = container.entries[patch];
  return {{bytes.data(), bytes.size()}, container.version,      patch, entry.point_count, entry.reference_count,
          container.owned_base[patch],  container.point_count()};
}

}  // namespace psplit
