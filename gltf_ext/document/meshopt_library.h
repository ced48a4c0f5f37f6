// What the linked meshoptimizer codes: version 0 of the codec of attributes, and indices. A build without it
// codes nothing.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gltf_ext/document/asset_records.h"

namespace psplit {

// Whether the library knows the version of a stream, whose first byte is `header`.
bool library_reads(const MeshoptRecord& view, uint8_t header);

// As decode_meshopt_rows, of what library_reads.
bool library_decode(const MeshoptRecord& view, std::span<const uint8_t> bytes, uint8_t* rows);

// As encode_meshopt_rows. Lists of triangles may come back with other corners first.
std::vector<uint8_t> library_encode(const MeshoptRecord& view, std::span<const uint8_t> rows);

}  // namespace psplit
