// A glTF asset as JSON and bytes. It is edited in place: all data that psplit does not own passes through
// unchanged.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "gltf_ext/document/buffer.h"
#include "gltf_ext/json/json.h"
#include "src/export.h"
#include "src/status.h"

namespace psplit {

// `json` always stays a valid glTF tree and keeps the order of its members. `buffers` has one entry for each of
// json["buffers"], whether its bytes came from a GLB chunk, a data URI or a file.
struct Document {
  Json json;
  std::vector<Buffer> buffers;   // resolved bytes, at least byteLength each
  std::filesystem::path source;  // "-" for stdin; the directory that relative URIs start from
  // Files that were read: the asset itself (unless it is stdin), its buffers, its materials.
  std::vector<std::filesystem::path> files;
  bool from_glb = false;
  bool from_draco = false;  // a .drc file (gltf_ext/convert/draco_file.h)
};

// Reads a .gltf or .glb, told apart by content, not by name; "-" is stdin. Loads every buffer: GLB chunk, data
// URI, or a file in the asset's folder. URIs are percent-decoded; a URI that leaves the folder is an error.
// Buffer views that meshoptimizer compressed are decoded (decode_meshopt.h). Images stay as they are. The
// structure is checked (check_structure.h), so that later code can index accessors, buffer views and buffers
// safely. With FileAccess::kMap, a GLB or a buffer's file of at least kMappedBytes is mapped: an output that is
// written by rename may replace it. Errors: kIo, kInvalidInput, kUnsupported.
inline constexpr uint64_t kMappedBytes = uint64_t{4} << 20;
PSPLIT_EXPORT Expected<Document> read_document(const std::filesystem::path& path,
                                               FileAccess access = FileAccess::kRead);

// The same for a file in memory. If the bytes are moved in, those of a GLB become the buffer without a copy.
PSPLIT_EXPORT Expected<Document> parse_document(std::vector<uint8_t>&& file,
                                                const std::filesystem::path& source);
PSPLIT_EXPORT Expected<Document> parse_document(std::span<const uint8_t> file,
                                                const std::filesystem::path& source);
// The same for a mapped file; the buffers' files are mapped as well.
Expected<Document> parse_document(MappedFile file, const std::filesystem::path& source);

// A new document with one mesh, one node and one scene.
PSPLIT_EXPORT Document new_document();

// Whether the buffer has no bytes although its byteLength is not 0: an unknown extension would supply them.
bool has_no_bytes(const Document& document, size_t buffer);

// The bytes of a buffer view. Errors: kInvalidInput if the index or the range is invalid; kUnsupported if the
// view was compressed by a newer meshoptimizer than the linked one, or if its buffer has no bytes.
PSPLIT_EXPORT Expected<std::span<const uint8_t>> buffer_view_bytes(const Document& document, int64_t index);

// Appends bytes as a new buffer view (4-byte aligned) and returns its index.
PSPLIT_EXPORT int64_t append_buffer_view(Document& document, std::span<const uint8_t> bytes);

}  // namespace psplit
