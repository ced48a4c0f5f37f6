// Metadata as libdraco reads them. Our own reader must find the same.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "psplit/decode.h"

namespace psplit {

// Nothing if libdraco rejects the metadata. Parts are in the order of their names, which is all that libdraco
// keeps. `stream` has metadata.
std::optional<StreamMetadata> read_metadata_with_libdraco(std::span<const uint8_t> stream);

// Sorts all parts by their names.
void sort_parts(StreamMetadata& metadata);

}  // namespace psplit
