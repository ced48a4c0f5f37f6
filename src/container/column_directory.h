// The directory of a container of versions 1 and 2: a column for each member of a row, with a base and 0, 1, 2
// or 4 bytes a value. Specification: "columns" (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/container/stream_entry.h"
#include "src/status.h"

namespace psplit {

inline constexpr size_t kColumnDescriptorBytes = 5 * 8;

// Reads the descriptors and columns at the start of `bytes`, one value of each column into each of `entries`.
// Returns the number of their bytes, or kInvalidInput.
Expected<size_t> read_column_directory(std::span<const uint8_t> bytes, std::span<StreamEntry> entries);

// Appends the descriptors and columns.
void append_column_directory(std::span<const StreamEntry> entries, std::vector<uint8_t>& bytes);

}  // namespace psplit
