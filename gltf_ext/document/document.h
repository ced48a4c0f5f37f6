// A glTF asset as JSON and bytes, edited in place: what psplit does not own passes through untouched.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "gltf_ext/json/json.h"
#include "src/status.h"

namespace psplit {

// `json` always stays a valid glTF tree with its member order kept. Buffer bytes live beside it, one entry per
// json["buffers"], whatever they came from (GLB chunk, data URI, file).
struct Document {
  Json json;
  std::vector<std::vector<uint8_t>> buffers;  // resolved bytes, at least byteLength each
  std::filesystem::path source;               // "-" for stdin; the directory that relative URIs start from
  // Files that were read: the asset itself (unless it is stdin), its buffers, its materials.
  std::vector<std::filesystem::path> files;
  bool from_glb = false;
  bool from_draco = false;  // a .drc file (gltf_ext/convert/draco_file.h)
};

// Reads .gltf or .glb (told apart by content, not by name); "-" reads a GLB or glTF from stdin. Loads every
// buffer: GLB chunk, data URI, or a file under the asset's folder (a URI that escapes it is refused; percent
// encoding is decoded). Buffer views that meshoptimizer compressed are decoded (decode_meshopt.h).
// Images stay as they are. Validates structure enough that later code can index accessors, buffer views and
// buffers safely: every function here returns kInvalidInput rather than read out of bounds. Errors: kIo,
// kInvalidInput, kUnsupported.
Expected<Document> read_document(const std::filesystem::path& path);

// The same of a file whose bytes are at hand. Those of a GLB become the buffer's, where they are given away.
Expected<Document> parse_document(std::vector<uint8_t>&& file, const std::filesystem::path& source);
Expected<Document> parse_document(std::span<const uint8_t> file, const std::filesystem::path& source);

// A new document of one mesh, one node, one scene; used for PLY and its like, and by `generate`.
Document new_document();

// The bytes of a buffer view. Errors: kInvalidInput where index or range are wrong, kUnsupported where the view
// is compressed by a meshoptimizer newer than the one at hand.
Expected<std::span<const uint8_t>> buffer_view_bytes(const Document& document, int64_t index);

// Appends bytes as a new buffer view (4-byte aligned) and returns its index.
int64_t append_buffer_view(Document& document, std::span<const uint8_t> bytes);

}  // namespace psplit
