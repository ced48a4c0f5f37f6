// What psplit itself does with a document, beside psplit/document.h.
#pragma once

#include "gltf_ext/json/json_fwd.h"
#include "psplit/document.h"
#include "system/mapped_file.h"

namespace psplit {

// Where an error of a primitive is; with the document, the file as well.
inline Place place_of(PrimitiveId id) {
  return {{}, static_cast<int64_t>(id.mesh), static_cast<int64_t>(id.primitive)};
}
inline Place place_of(const Document& document, PrimitiveId id) {
  Place place = place_of(id);
  place.file = document.source.string();
  return place;
}

// The bytes of a mapped file.
inline Buffer buffer_of(const MappedFile& file) { return {file.bytes(), file.owner()}; }

// parse_document for a mapped file; the buffers' files are mapped as well.
Expected<Document> parse_document(MappedFile file, const std::filesystem::path& source);

// Whether the file has no bytes for the buffer: memory has none either, or meshoptimizer's extension supplies
// them, and the bytes in memory are decoded ones.
bool is_placeholder(const Document& document, size_t buffer);

// Whether the buffer has no bytes although its byteLength is not 0: an unknown extension would supply them.
bool has_no_bytes(const Document& document, size_t buffer);

// Appends a buffer and returns its index.
size_t append_buffer(Document& document, Buffer bytes);
// From this size on, bytes are worth a buffer of their own, because moving them takes long.
inline constexpr size_t kLargeBuffer = size_t{1} << 20;

}  // namespace psplit
