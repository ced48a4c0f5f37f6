// A glTF asset as JSON and bytes, edited in place: what psplit does not own passes through untouched.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>
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
  std::vector<std::filesystem::path>
      files;  // that were read: the asset, if it is one, its buffers and materials
  bool from_glb = false;
  bool from_draco = false;  // a .drc file (gltf_ext/convert/draco_file.h)
};

// Reads .gltf or .glb (told apart by content, not by name); "-" reads a GLB or glTF from stdin. Loads every
// buffer: GLB chunk, data URI, or a file under the asset's folder (a URI that escapes it is refused; percent
// encoding is decoded). Buffer views that meshoptimizer compressed are decoded (gltf_ext/document/meshopt.h).
// Images stay as they are. Validates structure enough that later code can index accessors, buffer views and
// buffers safely: every function here returns kInvalidInput rather than read out of bounds. Errors: kIo,
// kInvalidInput, kUnsupported.
Expected<Document> read_document(const std::filesystem::path& path);

// The same of a file whose bytes are at hand. Those of a GLB become the buffer's, where they are given away.
Expected<Document> parse_document(std::vector<uint8_t>&& file, const std::filesystem::path& source);
Expected<Document> parse_document(std::span<const uint8_t> file, const std::filesystem::path& source);

// A new document of one mesh, one node, one scene; used for PLY and its like, and by `generate`.
Document new_document();

// What becomes of images that are files when the asset is written to another place.
enum class ImagePlacement {
  kEmbed,      // buffer views
  kCopy,       // files in the output's folder
  kReference,  // the files of the input, by URIs that lead there from the output's folder
};

struct WriteOptions {
  // By default a GLB embeds, and a .gltf copies.
  std::optional<ImagePlacement> images;
};

struct WriteReport {
  std::vector<std::string> warnings;         // what dangles in the output, or is lost
  std::vector<std::string> notes;            // what has another name than it had
  std::vector<std::filesystem::path> files;  // all files of the output, written or there already
  size_t embedded_images = 0, copied_images = 0;
  uint64_t image_bytes = 0;  // of both, every file once
};

// Writes by the extension of `path` (.glb, .gltf with its .bin beside it, "-" GLB on stdout). The file appears
// whole or not at all (written beside and renamed). A .bin is named after its content, so that a .gltf and its
// .bin change together; those that a replaced .gltf had go, unless the document was read from it. All buffers
// become one; of a .gltf, data that only a fallback of compressed primitives has become a second.
// No other file is replaced: an image whose name is taken is copied under a name by its content.
Status write_document(const Document& document, const std::filesystem::path& path,
                      const WriteOptions& options = {}, WriteReport* report = nullptr);

// The bytes of a buffer view. Errors: kInvalidInput where index or range are wrong, kUnsupported where the view
// is compressed by a meshoptimizer newer than the one at hand.
Expected<std::span<const uint8_t>> buffer_view_bytes(const Document& document, int64_t index);

// Appends bytes as a new buffer view (4-byte aligned) and returns its index.
int64_t append_buffer_view(Document& document, std::span<const uint8_t> bytes);

// Drops accessors and buffer views in `freed_accessors` and those buffer views that nothing refers to any
// more, renumbers what refers to the rest (known extensions included), and drops the bytes. Keeps a view when
// an unknown extension might refer to it.
void drop_unused(Document& document, const std::vector<int64_t>& freed_accessors);

}  // namespace psplit
