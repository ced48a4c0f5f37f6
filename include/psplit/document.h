// A glTF asset as JSON and bytes: read, edited in place, and written. All data that psplit does not own passes
// through unchanged.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "psplit/base.h"
#include "psplit/decode.h"
#include "psplit/mesh.h"

namespace psplit {

struct AssetRecords;

// A primitive of a document, by the index of its mesh and its index in that mesh.
struct PrimitiveId {
  size_t mesh = 0;
  size_t primitive = 0;

  friend bool operator==(const PrimitiveId& a, const PrimitiveId& b) {
    return a.mesh == b.mesh && a.primitive == b.primitive;
  }
  friend bool operator<(const PrimitiveId& a, const PrimitiveId& b) {
    return std::tie(a.mesh, a.primitive) < std::tie(b.mesh, b.primitive);
  }
};

// The JSON of an asset, a tree of nlohmann-json's, which is edited in place.
class PSPLIT_EXPORT AssetTree {
 public:
  AssetTree();
  AssetTree(const AssetTree& other);
  AssetTree(AssetTree&& other) noexcept;
  AssetTree& operator=(AssetTree other) noexcept;
  ~AssetTree();

  // Objects keep the order of their members. In a mesh with coarse primitives, the full ones are in
  // `primitives` and the coarse ones in its extension; a file has them the other way round.
  const nlohmann::ordered_json& json() const;
  // The JSON for editing. Discards the records, so do not edit through an older reference after a call of
  // records(): that edit would be missed.
  nlohmann::ordered_json& json();

  // The JSON's statements about geometry, for psplit itself. Parsed at the first call after an edit; valid
  // until the next edit. Empty if check() fails. Thread-safe.
  const AssetRecords& records() const;
  // Checks that the JSON has the structure that records need, as every document has when it is read. Errors:
  // kInvalidInput if edits broke it.
  Status check() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Bytes that it owns, or that it shares with other buffers, such as a mapped file. Both are read alike.
class PSPLIT_EXPORT Buffer {
 public:
  Buffer() = default;
  Buffer(std::vector<uint8_t> bytes) : owned_(std::move(bytes)) {}
  Buffer(Span<const uint8_t> bytes, std::shared_ptr<const void> owner)
      : shared_(bytes), owner_(std::move(owner)) {}

  Span<const uint8_t> bytes() const { return is_shared() ? shared_ : Span(owned_); }
  const uint8_t* data() const { return bytes().data(); }
  size_t size() const { return bytes().size(); }
  const uint8_t* begin() const { return bytes().begin(); }
  const uint8_t* end() const { return bytes().end(); }
  bool empty() const { return bytes().empty(); }
  bool is_shared() const { return !shared_.empty(); }

  // The bytes for editing; shared bytes are copied first.
  std::vector<uint8_t>& own();
  // Keeps only this range, which must be within bytes().
  void cut_to(size_t offset, size_t length);

 private:
  std::vector<uint8_t> owned_;  // empty while bytes are shared
  Span<const uint8_t> shared_;
  std::shared_ptr<const void> owner_;
};

// How the bytes of large files get into memory.
enum class FileAccess {
  kRead,  // copied
  // Mapped. If the file becomes shorter or unreadable while it is mapped, the process exits with a message and
  // the code kIo: suitable for commands, not for a library.
  kMap,
};

// Describes the points of a mesh file that was read into temporary files because it exceeds the memory limit.
// All buffers of its document are such files.
struct SpooledPoints {
  // Equal points are one point: STL stores a point for each corner, and reading OBJ may repeat points.
  bool are_repeated = false;
  // If not empty, 12 bytes for each point: points are equal only if these bytes are.
  Buffer numbers{};
};

// The point cloud stream of a .drc file. No extension holds such streams, so the document has the decoded
// points as a plain primitive.
struct StoredCloud {
  StreamDescription stream;
  uint64_t stream_bytes = 0;
};

// `buffers` has one entry for each of json()["buffers"], whether its bytes came from a GLB chunk, a data URI or
// a file.
struct Document : AssetTree {
  std::vector<Buffer> buffers;   // resolved bytes, at least byteLength each
  std::filesystem::path source;  // "-" for stdin; the directory that relative URIs start from
  // Files that were read: the asset itself (unless it is stdin), its buffers, its materials.
  std::vector<std::filesystem::path> files;
  bool from_glb = false;
  uint64_t text_bytes = 0;  // of the JSON of a .gltf that was read, without buffer data in it
  bool from_draco = false;  // a .drc file
  bool is_retyped = false;  // a .drc file with values of types that accessors lack, which were converted
  std::optional<StoredCloud> cloud{};
  std::optional<SpooledPoints> spooled{};
};

// Reads a .gltf or .glb, told apart by content, not by name; "-" is stdin. Loads every buffer: GLB chunk, data
// URI, or a file in the asset's folder. URIs are percent-decoded; a URI that leaves the folder is an error.
// Buffer views that meshoptimizer compressed are decoded, and keep their compressed bytes. Images stay as they
// are. The structure is checked. With FileAccess::kMap, a GLB or a buffer's file of at least kMappedBytes is
// mapped; an output may still replace it, because outputs are written by rename. Errors: kIo, kInvalidInput,
// kUnsupported.
inline constexpr uint64_t kMappedBytes = uint64_t{4} << 20;
PSPLIT_EXPORT Expected<Document> read_document(const std::filesystem::path& path,
                                               FileAccess access = FileAccess::kRead);

// Reads a document from memory. If the bytes are moved in, a GLB's binary chunk becomes the buffer without a
// copy.
PSPLIT_EXPORT Expected<Document> parse_document(std::vector<uint8_t>&& file,
                                                const std::filesystem::path& source);
PSPLIT_EXPORT Expected<Document> parse_document(Span<const uint8_t> file, const std::filesystem::path& source);

// All primitives, mesh by mesh.
PSPLIT_EXPORT std::vector<PrimitiveId> all_primitives(const Document& document);

// A new document with one mesh, one node and one scene.
PSPLIT_EXPORT Document new_document();

// The bytes of a buffer view that exists. Errors: kUnsupported if the view was compressed by a newer
// meshoptimizer than the linked one, or if its buffer has no bytes; kInvalidInput if the buffer is too short.
PSPLIT_EXPORT Expected<Span<const uint8_t>> buffer_view_bytes(const Document& document, int64_t index);

// Removes meshoptimizer's extension from all views whose decoded bytes are in memory, with the compressed
// bytes.
PSPLIT_EXPORT void make_meshopt_views_plain(Document& document);

// Appends bytes as a new buffer view (4-byte aligned) and returns its index.
PSPLIT_EXPORT int64_t append_buffer_view(Document& document, Span<const uint8_t> bytes);

// A mesh as a document: one scene, one node, one mesh, one plain primitive.
PSPLIT_EXPORT Document document_from_mesh(const Mesh& mesh);

// ---- Files ----

// How the output refers to image files.
enum class ImagePlacement {
  kEmbed,      // buffer views
  kCopy,       // files in the output's folder
  kReference,  // the input's files, by URIs that lead to them from the output's folder
};

struct WriteOptions {
  // By default a GLB embeds, and a .gltf copies.
  std::optional<ImagePlacement> images;
  bool replace_read_only = false;  // otherwise a file without permission to write is an error
};

struct WriteReport {
  std::vector<std::string> warnings;         // references that dangle in the output, and lost data
  std::vector<std::string> notes;            // renamed files
  std::vector<std::filesystem::path> files;  // all files of the output, newly written or already there
  size_t embedded_images = 0, copied_images = 0;
  uint64_t image_bytes = 0;  // of embedded and copied images; every file counts once
};

// The size of the document as a GLB whose images stay where they are.
PSPLIT_EXPORT uint64_t glb_bytes(const Document& document);

// The extension of `path` gives the format: .glb, or .gltf with its .bin beside it; "-" writes a GLB to stdout.
// The file appears whole or not at all: it is written under another name and then renamed. A .bin is named
// after its content, so that a .gltf and its .bin change together. If a .gltf is replaced, its old .bin files
// are removed, unless `document` was read from it. All buffers become one. A .gltf gets a second buffer for
// data that only coarse primitives, or the fallback of compressed ones, use. No other file is replaced: if the
// name of a copied image is taken, the copy is named after its content. Errors: kUsage, kIo, kUnsupported.
PSPLIT_EXPORT Status write_document(const Document& document, const std::filesystem::path& path,
                                    const WriteOptions& options = {}, WriteReport* report = nullptr);

// ---- Memory ----

// Limits the memory for decoding one primitive. Primitives that fit are decoded in memory. Larger ones are
// decoded window by window into an unnamed temporary file in `folder`.
struct MemoryLimit {
  uint64_t bytes = 0;  // 0: no limit
  std::filesystem::path folder = ".";

  bool allows(uint64_t needed) const { return bytes == 0 || needed <= bytes; }
};

}  // namespace psplit
