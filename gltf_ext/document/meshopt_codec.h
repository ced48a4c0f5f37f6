// What meshoptimizer's extensions do with the rows of one buffer view. Version 1 of the codec of attributes is
// psplit's own code; the others are meshoptimizer's, and a build without it reads none of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gltf_ext/document/asset_records.h"

namespace psplit {

// Why views are not readable here, as the end of a sentence.
const char* why_meshopt_is_unreadable();

// Whether the version of the compressed bytes is known.
bool is_readable_meshopt(const MeshoptRecord& view, std::span<const uint8_t> bytes);

// The preconditions of the decoders, some of which meshoptimizer only asserts.
bool is_legal_meshopt(const MeshoptRecord& view);

// An upper bound of the decoded bytes that `bytes`, in the view's codec, can hold.
uint64_t most_decoded_bytes(const MeshoptRecord& view, std::span<const uint8_t> bytes);

// Decodes a legal view into view.decoded_bytes() bytes, without undoing its filter. Returns false if the bytes
// are malformed.
bool decode_meshopt_rows(const MeshoptRecord& view, std::span<const uint8_t> bytes, uint8_t* rows);

// kUsage in a build without meshoptimizer, which compresses nothing.
Status check_meshopt_encoder();

// Compresses view.count rows by the view's mode, without its filter: rows of attributes in version 1 of the
// codec if the view's extension has it. Returns nothing if they would not come back with the same bytes.
std::vector<uint8_t> encode_meshopt_rows(const MeshoptRecord& view, std::span<const uint8_t> rows);

}  // namespace psplit
