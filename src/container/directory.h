// The directory of a container: a row of numbers for each stream, in bits. A number is coded as its distance
// from what the rows before let expect, modulo 2^32, so that all rows can be written. Specification:
// "directory" (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "psplit/base.h"
#include "psplit/decode.h"

namespace psplit {

// The least bits of a row. A reader checks by them whether a directory can have as many rows as it claims.
inline constexpr uint64_t kLeastRowBits = 4;

// Reads one row into each of `entries`, of which the last may be the residue. Returns how many skeletons the
// directory counts: every condensed stream has one of these. Errors: kInvalidInput for bits that end early or
// go on too long, and for a skeleton beyond the count, with the row as the patch of the place.
Expected<uint32_t> read_directory(std::span<const uint8_t> bytes, bool has_residue,
                                  std::span<StreamEntry> entries);

// The residue is not condensed.
std::vector<uint8_t> write_directory(std::span<const StreamEntry> entries, bool has_residue);

}  // namespace psplit
