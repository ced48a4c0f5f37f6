// Version 1 of the codec of attributes, as KHR_meshopt_compression specifies it ("Mode 0: attributes"). It does
// not depend on the linked meshoptimizer, so the bytes are the same in every build.
//
// Both functions may be called by several threads at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace psplit {

// What the first byte of a stream says: the codec of attributes, and its version.
inline constexpr uint8_t kVerticesOfVersion1 = 0xa1;
// No stream of version 1 has more decoded bytes for each of its bytes: blocks of zeros take 2 bits for 256
// bytes.
inline constexpr uint64_t kMostBytesOfVersion1 = 1024;

// Whether rows may have that many bytes.
constexpr bool is_row_of_vertices(size_t stride) { return stride % 4 == 0 && stride >= 4 && stride <= 256; }

// Decodes any bytes into whole rows of `stride` bytes, a legal stride. Returns false if the bytes are not a
// stream of as many rows: the rows are then undefined.
bool decode_vertices(std::span<const uint8_t> bytes, size_t stride, std::span<uint8_t> rows);

// Encodes whole rows: each channel of 4 bytes with the deltas, and each block and group of these with the bits,
// that take the fewest bytes.
std::vector<uint8_t> encode_vertices(std::span<const uint8_t> rows, size_t stride);

}  // namespace psplit
