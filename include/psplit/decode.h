// Decoders. Most programs need loader.h alone, which takes a decoder as a value, a DecodeBackend. This header
// has what such a decoder is, the CPU's, and functions for single Draco files, of meshes or point clouds.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <map>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "psplit/base.h"
#include "psplit/draco_types.h"
#include "psplit/mesh.h"
#include "psplit/parallel.h"

namespace psplit {

// ---- Containers of patches ----

// The opened bytes of a container, the input of all decoders: checked once, and shared between threads. Opaque:
// callers only pass references on. CompressedPrimitive::container (loader.h) returns it, and states its
// lifetime.
struct PatchContainer;

// One row of a container's directory.
struct StreamEntry {
  uint32_t stream_bytes = 0;
  uint32_t face_count = 0;
  uint32_t point_count = 0;      // as decoded, references included
  uint32_t reference_count = 0;  // points that refer to one of another stream, or to an earlier one of this
                                 // stream
  uint32_t stitch_bytes = 0;
  bool is_condensed = false;  // its fields are coded with the models of the container's head
  uint8_t skeleton = 0;       // of a condensed stream: the index of its skeleton in the head

  friend bool operator==(const StreamEntry& a, const StreamEntry& b) {
    const auto members = [](const StreamEntry& of) {
      return std::tie(of.stream_bytes, of.face_count, of.point_count, of.reference_count, of.stitch_bytes,
                      of.is_condensed, of.skeleton);
    };
    return members(a) == members(b);
  }
};

// Requests a Draco attribute, by its unique id, as a glTF attribute.
struct AttributeRequest {
  std::string semantic;
  uint32_t unique_id = 0;
  ComponentType component_type = ComponentType::kFloat32;
  uint8_t component_count = 3;
  bool normalized = false;

  size_t value_bytes() const { return component_bytes(component_type) * component_count; }
};

// Bounds the decoded positions of all points that the patch owns or its faces use. If `low` is above `high`, no
// position is finite.
struct PatchBox {
  std::array<double, 3> low{}, high{};
};

// The caller's memory, as bytes. Spans, vectors and arrays of trivially copyable values convert to it.
class WritableBytes : public Span<std::byte> {
 public:
  WritableBytes() = default;
  template <typename Values,
            typename T = std::remove_reference_t<decltype(*std::data(std::declval<Values&>()))>,
            typename = std::enable_if_t<std::is_trivially_copyable_v<T> && !std::is_const_v<T> &&
                                        std::is_convertible_v<Values, Span<T>>>>
  WritableBytes(Values&& values)  // NOLINT: implicit
      : Span(reinterpret_cast<std::byte*>(std::data(values)), std::size(values) * sizeof(T)) {}
};

// The destination of an attribute: one value for each point, `stride` bytes from one value to the next. A
// stride of 0 means tightly packed. Any alignment is allowed. The bytes between two values are not touched.
struct AttributeBuffer {
  WritableBytes bytes;
  size_t stride = 0;
};

// The caller's memory for one mesh. No two parts of it overlap.
struct PrimitiveBuffers {
  WritableBytes indices;                      // three for each face, tightly packed, aligned to their size
  uint32_t index_bytes = 4;                   // 4, or 2 if there are no more than 65,535 points
  std::vector<AttributeBuffer> attributes{};  // one for each requested attribute
};

// A container to decode into one mesh, and the wanted attributes. Both must outlive decoding.
struct DecodeTask {
  const PatchContainer* container = nullptr;
  Span<const AttributeRequest> requests;
};

// Returns the memory for a task's mesh, or an error, which ends the task. A backend calls it as soon as it
// knows the counts; for some stock streams, that is after decoding. The memory must have room for the counts,
// and its strides must not be 0. Called from any thread, possibly more than once for a task, then with equal
// counts.
using BuffersFor =
    std::function<Expected<PrimitiveBuffers>(size_t task, uint32_t point_count, uint32_t face_count)>;

// Called with the number of finished steps and their total, from any thread.
using Progress = std::function<void(size_t done, size_t total)>;

// Lets a caller follow work, and stop it.
struct Watch {
  Progress progress{};                      // in steps of the backend: patches, or tasks
  const std::atomic<bool>* stop = nullptr;  // decoding ends when it becomes true; may be null

  bool stopped() const { return stop != nullptr && stop->load(std::memory_order_relaxed); }
};

struct PSPLIT_EXPORT DecodeBackend {
  std::string name;
  // Decodes all tasks, and stitches their patches. Returns a status for each task, in their order. An error of
  // one task does not affect others. After an error the task's memory is unspecified. Thread-safe.
  std::function<std::vector<Status>(Span<const DecodeTask> tasks, const BuffersFor& buffers_for,
                                    const ThreadPool& pool, const Watch& watch)>
      decode_into;

  // Decodes to new meshes: a mesh or an error for each task. Errors: as decode_into and allocate_mesh.
  std::vector<Expected<Mesh>> decode(Span<const DecodeTask> tasks, const ThreadPool& pool,
                                     const Progress& progress = {}) const;
  Expected<Mesh> decode(const PatchContainer& container, Span<const AttributeRequest> requests,
                        const ThreadPool& pool) const;
};

// Sets the counts and attributes of `mesh`, and allocates its memory without zeroing it. Errors: kInvalidInput
// if `stored_bytes`, the size of the compressed mesh, does not justify that much memory.
PSPLIT_EXPORT Expected<PrimitiveBuffers> allocate_mesh(uint32_t point_count, uint32_t face_count,
                                                       Span<const AttributeRequest> requests,
                                                       uint64_t stored_bytes, Mesh& mesh);

// ---- The decoder for CPUs ----

// Decodes containers patch by patch on all threads of the pool, and stock Draco 2.2 mesh streams on one thread
// each. Results equal libdraco's to the bit. Safe for untrusted bytes. Errors: kUnsupported for older
// bitstreams, kInvalidInput for anything else that cannot be decoded, with the patch as its place. Checks
// before each patch whether to stop, and reports progress after each. Thread-safe.
PSPLIT_EXPORT DecodeBackend cpu_backend();

// Frees the memory that threads keep from one call to the next: for each of the threads that decoded at the
// same time, as much as its largest streams took. Threads that are decoding now keep theirs. Thread-safe.
PSPLIT_EXPORT void release_scratch();

// ---- What a Draco stream contains ----

struct StreamAttribute {
  uint32_t unique_id = 0;
  DracoSemantic semantic = DracoSemantic::kGeneric;
  DataType type = DataType::kFloat32;  // of the decoded values
  uint8_t components = 0;
  bool normalized = false;
  uint8_t bits = 0;  // of a component on its grid, or on a normal's octahedral grid; 0 if values are stored
                     // exactly
  // The grid of quantized values, unless they are on an octahedron: origin + i * range / (2^bits - 1), with an
  // origin for each component.
  float range = 0;
  std::vector<float> origin{};

  bool is_octahedral() const { return bits > 0 && origin.empty(); }

  friend bool operator==(const StreamAttribute& a, const StreamAttribute& b) {
    const auto members = [](const StreamAttribute& of) {
      return std::tie(of.unique_id, of.semantic, of.type, of.components, of.normalized, of.bits, of.range,
                      of.origin);
    };
    return members(a) == members(b);
  }
};

enum class StreamCoding : uint8_t {
  kSequential,
  kEdgebreaker,            // the standard traversal
  kEdgebreakerPredictive,  // streams before 2.2 only
  kEdgebreakerValence,
  kCloudSequential,  // point clouds
  kCloudKdTree,
};
constexpr bool is_cloud(StreamCoding coding) {
  return coding == StreamCoding::kCloudSequential || coding == StreamCoding::kCloudKdTree;
}
// "sequential", "edgebreaker", "edgebreaker-predictive", "edgebreaker-valence", "cloud-sequential",
// "cloud-kd-tree".
PSPLIT_EXPORT const char* coding_name(StreamCoding coding);

struct StreamDescription {
  StreamCoding coding = StreamCoding::kSequential;
  uint32_t face_count = 0, point_count = 0;  // as decoded; a point cloud has 0 faces
  std::vector<StreamAttribute> attributes;   // in the order of the stream

  friend bool operator==(const StreamDescription& a, const StreamDescription& b) {
    return a.coding == b.coding && a.face_count == b.face_count && a.point_count == b.point_count &&
           a.attributes == b.attributes;
  }
};

// A decoder for Draco meshes of bitstreams before 2.2, which psplit itself refuses. older_streams (encode.h)
// returns libdraco's. Both functions must be safe for untrusted bytes, and thread-safe. Errors: kInvalidInput.
// Streams before 1.3 have no unique ids: each attribute gets its index as its id.
struct OlderStreams {
  Expected<StreamDescription> (*describe)(Span<const uint8_t> stream) = nullptr;
  Expected<Mesh> (*decode)(Span<const uint8_t> stream, Span<const AttributeRequest> requests) = nullptr;
};

// Describes a stream: describe_stream, libdraco's function, or the second if the first fails.
using DescribeStream = std::function<Expected<StreamDescription>(Span<const uint8_t> stream)>;

// Returns a request for each attribute, in the same order, that decodes it to a form that glTF allows. The
// names are POSITION, NORMAL, TEXCOORD_n and COLOR_n for data of the types that glTF gives these names, and
// _GENERIC_n for all other data. 32-bit and 64-bit integers and doubles become floats, and bools become bytes.
// Integer colours are normalized. Errors: kUnsupported (a number of components that no glTF type has),
// kInvalidInput (no positions, or a repeated unique id).
PSPLIT_EXPORT Expected<std::vector<AttributeRequest>> gltf_attributes(Span<const StreamAttribute> attributes);

// ---- Whole Draco streams ----
//
// For streams whose attributes are not known in advance, such as .drc files. A stream is a mesh of bitstream
// 2.2, or a point cloud of 2.2 or 2.3. All functions decode on the calling thread, are safe for untrusted
// bytes, and are thread-safe. They allocate at most 64 MiB plus 4096 bytes for each byte of the stream, and as
// much again for results. If the attributes are known, or for many streams, loader.h is faster. Errors:
// kUnsupported for other bitstreams, kInvalidInput for anything else that cannot be decoded.

// Describes a stream, which requires decoding it.
PSPLIT_EXPORT Expected<StreamDescription> describe_stream(Span<const uint8_t> stream);

// Describes the Draco stream of a patch of an opened container, or of its residue, even if it is condensed. The
// place of an error is the patch.
PSPLIT_EXPORT Expected<StreamDescription> describe_patch(const PatchContainer& container, uint32_t number);

// Decodes all attributes to forms that glTF allows. A point cloud becomes a mesh without faces. gltf_attributes
// chooses names and types; its errors are returned as well. `description`, unless it is null, receives the
// stream's description.
PSPLIT_EXPORT Expected<Mesh> decode_draco(Span<const uint8_t> stream, StreamDescription* description = nullptr);

// One value for each point, tightly packed, in the stream's own type: description.components of
// description.type, little-endian.
struct GeometryAttribute {
  StreamAttribute description;
  Array<std::byte> values;
  // Whether the values are the stream's integers, before dequantization. Then each value is
  // description.components int32 numbers, or two for a normal on its octahedron.
  bool are_integers = false;

  // The type and number of a value's components, and its bytes.
  DataType type() const { return are_integers ? DataType::kInt32 : description.type; }
  uint32_t component_count() const {
    return are_integers && description.is_octahedral() ? 2 : description.components;
  }
  PSPLIT_EXPORT size_t stride() const;
};

// A decoded stream without glTF's names and limits. Faces, points and attributes are in the stream's order.
struct DracoGeometry {
  StreamCoding coding = StreamCoding::kSequential;
  uint32_t point_count = 0;
  Array<std::array<uint32_t, 3>> faces;  // none: a point cloud
  std::vector<GeometryAttribute> attributes;
};

// Decodes all attributes to the stream's types. With `integers`, decodes quantized attributes to places on
// their grids, normals to coordinates on the octahedron, and exact integers of at most 32 bits to int32. Other
// attributes keep their types.
PSPLIT_EXPORT Expected<DracoGeometry> decode_geometry(Span<const uint8_t> stream, bool integers = false);

// The values that a stream stores for an attribute: each once, in libdraco's order.
struct StoredValues {
  uint32_t value_count = 0;
  bool one_a_point = false;   // value i belongs to point i
  bool has_integers = false;  // see decode_geometry
};

// The contents of a stream, without its values. Finding them is faster than decoding; values may still turn out
// to be invalid when they are decoded.
struct StreamOutline {
  StreamDescription description;  // for a kD-tree without bits, ranges and origins, which come after its values
  std::vector<StoredValues> stored;  // an element for each attribute
};
PSPLIT_EXPORT Expected<StreamOutline> outline_stream(Span<const uint8_t> stream);

// The destination of an attribute.
struct AttributePlaces {
  // Room for value_count values, or for one value per point if value_of_point is null. Null: the attribute is
  // not wanted.
  std::byte* values = nullptr;
  uint32_t* value_of_point = nullptr;  // the number of each point's value; may be null
  bool integers = false;               // write integers; requires StoredValues::has_integers
  size_t stride = 0;                   // bytes from one value to the next; 0: tightly packed
};
struct GeometryPlaces {
  void* faces = nullptr;                    // three points for each face, aligned to index_bytes
  std::vector<AttributePlaces> attributes;  // one for each of the stream's, in order
  // Called after each attribute is written, so that attributes can share one value_of_point array. May be
  // empty.
  std::function<void(size_t attribute)> written{};
  uint32_t index_bytes = 4;  // or 2, if no point number is larger
};
// Called once the counts are known. `stored` has an element for each attribute.
using PlacesFor =
    std::function<Expected<GeometryPlaces>(const StreamDescription&, Span<const StoredValues> stored)>;

// Decodes a stream to the places that places_for returns. places_for may throw; its errors are returned.
PSPLIT_EXPORT Status decode_geometry(Span<const uint8_t> stream, const PlacesFor& places_for);

// Sets the known members of `geometry`, allocates memory for its faces and values without zeroing it, and
// returns their places. Errors: kInvalidInput if `stored_bytes`, the size of the stream, does not justify that
// much memory.
PSPLIT_EXPORT Expected<GeometryPlaces> allocate_geometry(const StreamDescription& description,
                                                         Span<const StoredValues> stored, bool integers,
                                                         uint64_t stored_bytes, DracoGeometry& geometry);

// ---- Metadata of a Draco stream ----

// A node of a tree of named entries. Values have no stored type: the program that wrote them defines it.
struct Metadata {
  std::string name;                                     // unique among its siblings; "" for the root
  std::map<std::string, std::vector<uint8_t>> entries;  // the bytes of each value, not empty
  std::vector<Metadata> parts;                          // in the order of the stream

  // Null if there is no such entry or part.
  const std::vector<uint8_t>* find_entry(const std::string& entry) const {
    const auto found = entries.find(entry);
    return found == entries.end() ? nullptr : &found->second;
  }
  const Metadata* find_part(const std::string& part) const {
    for (const Metadata& candidate : parts)
      if (candidate.name == part) return &candidate;
    return nullptr;
  }
  friend bool operator==(const Metadata& a, const Metadata& b) {
    return a.name == b.name && a.entries == b.entries && a.parts == b.parts;
  }
};

struct AttributeMetadata {
  uint32_t unique_id = 0;  // of the attribute, which need not exist in the stream
  Metadata metadata;

  friend bool operator==(const AttributeMetadata& a, const AttributeMetadata& b) {
    return a.unique_id == b.unique_id && a.metadata == b.metadata;
  }
};

struct StreamMetadata {
  Metadata geometry;
  std::vector<AttributeMetadata> attributes;  // in the order of the stream; only of attributes with metadata

  friend bool operator==(const StreamMetadata& a, const StreamMetadata& b) {
    return a.geometry == b.geometry && a.attributes == b.attributes;
  }
};

// Reads the metadata of a Draco mesh or point cloud, bitstreams 1.3 to 2.3. The geometry is not decoded.
// Returns empty metadata if the stream has none. Safe for untrusted bytes. Takes at most a few hundred bytes
// for each byte of metadata. Errors: kUnsupported (another bitstream), kInvalidInput (no Draco stream, or
// metadata that end early, contradict themselves, have an empty value, repeat the name of a part, or nest more
// than a thousand times). Thread-safe.
PSPLIT_EXPORT Expected<StreamMetadata> read_metadata(Span<const uint8_t> stream);

}  // namespace psplit
