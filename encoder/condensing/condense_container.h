// Containers of version 2 as containers of version 3.
#pragma once

#include <optional>

#include "src/container/patch_container.h"
#include "src/parallel.h"

namespace psplit {

// A container of version 3 with the same streams, condensed as condense() says, and the same stitch map.
// `entries`, `stitch` and `streams` are those of write_container. Nothing if the directory of version 3 cannot
// hold the entries.
std::optional<std::vector<uint8_t>> condense_container(std::vector<StreamEntry> entries, bool has_residue,
                                                       std::span<const std::vector<uint8_t>> stitch,
                                                       std::span<const std::vector<uint8_t>> streams,
                                                       bool smallest, const ThreadPool& pool);

// The same for an opened container of version 2.
std::optional<std::vector<uint8_t>> condense_container(const PatchContainer& container, bool smallest,
                                                       const ThreadPool& pool);

}  // namespace psplit
