// What meshoptimizer does with the rows of one buffer view. A build without meshoptimizer reads none.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gltf_ext/document/asset_records.h"

namespace psplit {

// Why views are not readable here, as the end of a sentence.
const char* why_meshopt_is_unreadable();

// Whether the linked meshoptimizer knows the version of the compressed bytes, and the filter.
bool is_readable_meshopt(const MeshoptRecord& view, std::span<const uint8_t> bytes);

// The preconditions of meshoptimizer's decoders, some of which it only asserts.
bool is_legal_meshopt(const MeshoptRecord& view);

// Decodes a legal view into view.decoded_bytes() bytes, and undoes its filter in these. Decoding returns false
// if the bytes are malformed.
bool decode_meshopt_rows(const MeshoptRecord& view, std::span<const uint8_t> bytes, uint8_t* rows);
void undo_meshopt_filter(const MeshoptRecord& view, uint8_t* rows);

// kUsage in a build without meshoptimizer, which compresses nothing.
Status check_meshopt_encoder();

// Compresses view.count rows by the view's mode, without its filter. Returns nothing if they would not come
// back with the same bytes.
std::vector<uint8_t> encode_meshopt_rows(const MeshoptRecord& view, std::span<const uint8_t> rows);

}  // namespace psplit
