// The directory of a container of version 3: its rows in bits, each number as its distance from what the rows
// before let expect. Specification: "directory of version 3" (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "src/container/stream_entry.h"
#include "src/status.h"

namespace psplit {

// The least bits of a row. A reader checks by them whether a directory can have as many rows as it claims.
inline constexpr uint64_t kLeastRowBits = 5;

// The number of skeletons of a head, which is its first number; 0 without a head.
uint32_t count_skeletons(std::span<const uint8_t> head);

// Reads one row into each of `entries`. `skeleton_count` is the head's. Errors: kInvalidInput for bits that end
// early or go on too long, for numbers that do not have 32 bits, and for skeletons that do not exist, with the
// row as the patch of the place.
Status read_condensed_directory(std::span<const uint8_t> bytes, uint32_t skeleton_count,
                                std::span<StreamEntry> entries);

// Nothing if a number is too far from what the rows before let expect: a directory of version 2 holds any.
std::optional<std::vector<uint8_t>> write_condensed_directory(std::span<const StreamEntry> entries,
                                                              uint32_t skeleton_count);

}  // namespace psplit
