// Containers of Draco streams as containers of condensed streams.
#pragma once

#include "src/container/patch_container.h"
#include "src/parallel.h"

namespace psplit {

// A container with the same streams, condensed as condense() says, and the same stitch map. `entries`, `stitch`
// and `streams` are those of write_container.
std::vector<uint8_t> condense_container(std::vector<StreamEntry> entries, bool has_residue,
                                        std::span<const std::vector<uint8_t>> stitch,
                                        std::span<const std::vector<uint8_t>> streams, bool smallest,
                                        const ThreadPool& pool);

// The same for an opened container of Draco streams.
std::vector<uint8_t> condense_container(const PatchContainer& container, bool smallest, const ThreadPool& pool);

}  // namespace psplit
