// Draco streams as condense() takes them.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "src/container/patch_container.h"

namespace psplit {

// The streams of one primitive, with their rows. They must outlive it.
inline PatchContainer container_of_streams(std::span<const std::vector<uint8_t>> streams,
                                           std::vector<StreamEntry> rows) {
  PatchContainer container;
  container.entries = std::move(rows);
  container.stitch.resize(streams.size());
  container.streams.assign(streams.begin(), streams.end());
  return container;
}

}  // namespace psplit
