// A glTF asset as JSON and bytes. It is edited in place: all data that psplit does not own passes through
// unchanged.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <tuple>
#include <vector>

#include "gltf_ext/document/buffer.h"
#include "gltf_ext/json/json_fwd.h"
#include "src/container/stream_description.h"
#include "src/export.h"
#include "src/span.h"
#include "src/status.h"

namespace psplit {

struct PSPLIT_EXPORT AssetRecords;

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

// The JSON of an asset, which is edited in place, and the records that readers take. gltf_ext/json/json.h has
// the type of the tree.
class PSPLIT_EXPORT AssetTree {
 public:
  AssetTree();
  AssetTree(const AssetTree& other);
  AssetTree(AssetTree&& other) noexcept;
  AssetTree& operator=(AssetTree other) noexcept;
  ~AssetTree();

  // Objects keep the order of their members. A mesh with coarse primitives has them in its extension, and those
  // that the file has there in `primitives`: the opposite of a file.
  const Json& json() const;
  // The same, to be edited. The call forgets the records. So an edit through an older reference, after a call
  // of records(), would not be seen.
  Json& json();

  // What the JSON says about geometry (gltf_ext/document/asset_records.h). Read from it at the first call after
  // an edit; valid until the next edit. Empty if check() fails. Thread-safe.
  const AssetRecords& records() const;
  // Whether the JSON has the structure that records need. A document that was read has it. Errors:
  // kInvalidInput, if edits broke it.
  Status check() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The points of a mesh file that was read into temporary files, because it is larger than the memory that may
// be taken. These are all buffers of its document.
struct SpooledPoints {
  // STL has each point once for each corner, and an OBJ gets some again: equal points are one point.
  bool are_repeated = false;
  // If not empty, 12 bytes for each point: points are equal only if these are.
  Buffer numbers{};
};

// The stream of a .drc file of points. No extension holds such streams: the document has what it decodes to, as
// a plain primitive.
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
  uint64_t text_bytes = 0;  // of the JSON of a .gltf that was read, without the data of its buffers
  bool from_draco = false;  // a .drc file
  bool is_retyped = false;  // a .drc file with values of types that no accessor has: they become others
  std::optional<StoredCloud> cloud{};
  std::optional<SpooledPoints> spooled{};
};

// Where an error of a primitive is; with the document, the file as well.
inline Place place_of(PrimitiveId id) {
  return {{}, static_cast<int64_t>(id.mesh), static_cast<int64_t>(id.primitive)};
}
inline Place place_of(const Document& document, PrimitiveId id) {
  Place place = place_of(id);
  place.file = document.source.string();
  return place;
}

// Reads a .gltf or .glb, told apart by content, not by name; "-" is stdin. Loads every buffer: GLB chunk, data
// URI, or a file in the asset's folder. URIs are percent-decoded; a URI that leaves the folder is an error.
// Buffer views that meshoptimizer compressed are decoded, and keep their compressed bytes. Images stay as they
// are. The structure is checked. With FileAccess::kMap, a GLB or a buffer's file of at least kMappedBytes is
// mapped: an output that is written by rename may replace it. Errors: kIo, kInvalidInput, kUnsupported.
inline constexpr uint64_t kMappedBytes = uint64_t{4} << 20;
PSPLIT_EXPORT Expected<Document> read_document(const std::filesystem::path& path,
                                               FileAccess access = FileAccess::kRead);

// The same for a file in memory. If the bytes are moved in, those of a GLB become the buffer without a copy.
PSPLIT_EXPORT Expected<Document> parse_document(std::vector<uint8_t>&& file,
                                                const std::filesystem::path& source);
PSPLIT_EXPORT Expected<Document> parse_document(Span<const uint8_t> file, const std::filesystem::path& source);
// The same for a mapped file; the buffers' files are mapped as well.
Expected<Document> parse_document(MappedFile file, const std::filesystem::path& source);

// All primitives, mesh by mesh.
PSPLIT_EXPORT std::vector<PrimitiveId> all_primitives(const Document& document);

// A new document with one mesh, one node and one scene.
PSPLIT_EXPORT Document new_document();

// Whether the file has no bytes for the buffer: it has none in memory either, or meshoptimizer's extension
// supplies them, and what is in memory was decoded.
bool is_placeholder(const Document& document, size_t buffer);

// Whether the buffer has no bytes although its byteLength is not 0: an unknown extension would supply them.
bool has_no_bytes(const Document& document, size_t buffer);

// The bytes of a buffer view that exists. Errors: kUnsupported if the view was compressed by a newer
// meshoptimizer than the linked one, or if its buffer has no bytes; kInvalidInput if it has too few.
PSPLIT_EXPORT Expected<Span<const uint8_t>> buffer_view_bytes(const Document& document, int64_t index);

// Removes meshoptimizer's extension from all views whose decoded bytes are in memory, with the compressed
// bytes.
PSPLIT_EXPORT void make_meshopt_views_plain(Document& document);

// Appends a buffer and returns its index.
size_t append_buffer(Document& document, Buffer bytes);

// Appends bytes as a new buffer view (4-byte aligned) and returns its index.
PSPLIT_EXPORT int64_t append_buffer_view(Document& document, Span<const uint8_t> bytes);

}  // namespace psplit
