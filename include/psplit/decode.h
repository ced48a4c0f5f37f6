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

// Opened bytes, as all decoders take them: checked once, and shared between threads. Opaque: callers only hand
// on a reference. CompressedPrimitive::container (loader.h) gives it, and says how long it lives.
struct PatchContainer;

// One row of a container's directory.
struct StreamEntry {
  uint32_t stream_bytes = 0;
  uint32_t face_count = 0;
  uint32_t point_count = 0;      // as decoded, references included
  uint32_t reference_count = 0;  // points that another stream, or an earlier point of this one, owns
  uint32_t stitch_bytes = 0;
  bool is_condensed = false;  // its fields are coded with the models of the container's head
  uint8_t skeleton = 0;       // of a condensed stream: which of the head's skeletons it has

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

// Has the positions of all points that the faces of a patch use, and that it owns, as decoders return them. If
// `low` is above `high`, it has none that is finite.
struct PatchBox {
  std::array<double, 3> low{}, high{};
};

// The caller's memory, as bytes. Spans, vectors and arrays of plain values convert to it.
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

// Where an attribute goes: one value for each point, `stride` bytes from one value to the next. A stride of 0
// means tightly packed. Any alignment is allowed. The bytes between two values are not touched.
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

// A container, and the attributes that become one mesh. Both must outlive decoding.
struct DecodeTask {
  const PatchContainer* container = nullptr;
  Span<const AttributeRequest> requests;
};

// Gives a backend the memory for a task's mesh, or the error that ends the task. A backend calls it when it
// knows the counts, which for some stock streams is after decoding. The memory must have room for them, and its
// strides must not be 0. Called from any thread, for one task possibly again with the same counts.
using BuffersFor =
    std::function<Expected<PrimitiveBuffers>(size_t task, uint32_t point_count, uint32_t face_count)>;

// Called with the number of finished steps and their total, from any thread.
using Progress = std::function<void(size_t done, size_t total)>;

// How a caller follows work, and ends it.
struct Watch {
  Progress progress{};                      // in the steps that a backend takes: patches, or tasks
  const std::atomic<bool>* stop = nullptr;  // decoding ends when it becomes true; may be null

  bool stopped() const { return stop != nullptr && stop->load(std::memory_order_relaxed); }
};

struct PSPLIT_EXPORT DecodeBackend {
  std::string name;
  // Decodes all tasks, and stitches their patches. Returns a status for each task, in their order. The error of
  // one task does not affect another. After an error the task's memory may hold anything. Thread-safe.
  std::function<std::vector<Status>(Span<const DecodeTask> tasks, const BuffersFor& buffers_for,
                                    const ThreadPool& pool, const Watch& watch)>
      decode_into;

  // Decodes to new meshes: a mesh or an error for each task. Errors: those of decode_into and of allocate_mesh.
  std::vector<Expected<Mesh>> decode(Span<const DecodeTask> tasks, const ThreadPool& pool,
                                     const Progress& progress = {}) const;
  Expected<Mesh> decode(const PatchContainer& container, Span<const AttributeRequest> requests,
                        const ThreadPool& pool) const;
};

// Gives `mesh` the counts, the attributes and the memory for them, not zeroed. Errors: kInvalidInput if
// `stored_bytes`, which the mesh is decoded from, do not justify that much memory.
PSPLIT_EXPORT Expected<PrimitiveBuffers> allocate_mesh(uint32_t point_count, uint32_t face_count,
                                                       Span<const AttributeRequest> requests,
                                                       uint64_t stored_bytes, Mesh& mesh);

// ---- The decoder for CPUs ----

// Decodes containers patch by patch on all threads of the pool, and stock Draco 2.2 mesh streams on one thread
// each. Results equal libdraco's to the bit. Any bytes may be given. Errors: kUnsupported for streams of older
// bitstreams, kInvalidInput for everything else that cannot be decoded, with the patch as its place. Checks
// before each patch whether to stop, and reports progress after each. Thread-safe.
PSPLIT_EXPORT DecodeBackend cpu_backend();

// Frees the memory that threads keep from one call to the next: for each thread that decoded at the same time,
// as much as its largest streams took. Threads that are decoding keep theirs. Thread-safe.
PSPLIT_EXPORT void release_scratch();

// ---- What a Draco stream contains ----

struct StreamAttribute {
  uint32_t unique_id = 0;
  DracoSemantic semantic = DracoSemantic::kGeneric;
  DataType type = DataType::kFloat32;  // of the decoded values
  uint8_t components = 0;
  bool normalized = false;
  uint8_t bits = 0;  // of a component on its grid, or of a normal's octahedron; 0 if values are stored exactly
  // The grid of quantized values that are not on an octahedron: origin + i * range / (2^bits - 1), with an
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
  uint32_t face_count = 0, point_count = 0;  // as decoded; a point cloud has no faces
  std::vector<StreamAttribute> attributes;   // in the order of the stream

  friend bool operator==(const StreamDescription& a, const StreamDescription& b) {
    return a.coding == b.coding && a.face_count == b.face_count && a.point_count == b.point_count &&
           a.attributes == b.attributes;
  }
};

// What decodes Draco meshes of bitstreams before 2.2, which psplit itself refuses: libdraco (older_streams of
// encode.h). Both functions take any bytes, and are thread-safe. Errors: kInvalidInput. Streams before 1.3 have
// no unique ids: their attributes get their places as ids.
struct OlderStreams {
  Expected<StreamDescription> (*describe)(Span<const uint8_t> stream) = nullptr;
  Expected<Mesh> (*decode)(Span<const uint8_t> stream, Span<const AttributeRequest> requests) = nullptr;
};

// What describes a stream: describe_stream, libdraco, or one after the other.
using DescribeStream = std::function<Expected<StreamDescription>(Span<const uint8_t> stream)>;

// The requests that make each attribute one that glTF allows, in the same order. The names are POSITION,
// NORMAL, TEXCOORD_n and COLOR_n for data of the types that glTF gives these names, and _GENERIC_n for all
// other data. 32-bit and 64-bit integers and doubles become floats, and bools become bytes. Integer colours are
// normalized. Errors: kUnsupported (a number of components that no glTF type has), kInvalidInput (no positions,
// or two attributes with one unique id).
PSPLIT_EXPORT Expected<std::vector<AttributeRequest>> gltf_attributes(Span<const StreamAttribute> attributes);

// ---- Whole Draco streams ----
//
// Whole Draco streams, whose attributes are not known before: .drc files, and what libdraco's own users decode.
// A stream is a mesh of bitstream 2.2, or a point cloud of 2.2 or 2.3. All functions decode on the calling
// thread, take any bytes, and are thread-safe. They take at most 64 MiB and 4096 bytes for each byte of the
// stream, and as much again for results. If the attributes are known, or there are many streams,
// loader.h is faster. Errors: kUnsupported for other bitstreams, kInvalidInput for everything else
// that cannot be decoded.

// Describes a stream. It decodes the stream for that.
PSPLIT_EXPORT Expected<StreamDescription> describe_stream(Span<const uint8_t> stream);

// The same of a patch of an opened container, or of its residue: what describe_stream says of its Draco stream,
// also if it is condensed. Errors have the patch of a container as their place.
PSPLIT_EXPORT Expected<StreamDescription> describe_patch(const PatchContainer& container, uint32_t number);

// Decodes all attributes as glTF has them. A point cloud becomes a mesh without faces. gltf_attributes
// (decode.h) chooses names and types, and has errors of its own. `description`, if it
// is not null, becomes that of the stream.
PSPLIT_EXPORT Expected<Mesh> decode_draco(Span<const uint8_t> stream, StreamDescription* description = nullptr);

// One value for each point, tightly packed, in the type that the stream has: description.components of
// description.type, little-endian.
struct GeometryAttribute {
  StreamAttribute description;
  Array<std::byte> values;
  // Whether the values are the integers of the stream: then they are int32, description.components of them, or
  // two for a normal on its octahedron.
  bool are_integers = false;

  // Numbers of a value, and its bytes.
  DataType type() const { return are_integers ? DataType::kInt32 : description.type; }
  uint32_t component_count() const {
    return are_integers && description.is_octahedral() ? 2 : description.components;
  }
  PSPLIT_EXPORT size_t stride() const;
};

// A stream without the names and limits of glTF. Faces, points and attributes have the order of the stream.
struct DracoGeometry {
  StreamCoding coding = StreamCoding::kSequential;
  uint32_t point_count = 0;
  Array<std::array<uint32_t, 3>> faces;  // none: a point cloud
  std::vector<GeometryAttribute> attributes;
};

// Decodes all attributes to their own types. With `integers`, to the integers that the stream has: places on
// the grid of a quantized attribute, coordinates on the octahedron of a normal. Attributes that are stored
// exactly have integers too, if they are integers of at most 32 bits.
PSPLIT_EXPORT Expected<DracoGeometry> decode_geometry(Span<const uint8_t> stream, bool integers = false);

// What a stream stores of an attribute: each value once, in the order in which libdraco has them.
struct StoredValues {
  uint32_t value_count = 0;
  bool one_a_point = false;   // value i is that of point i
  bool has_integers = false;  // see decode_geometry
};

// What a stream contains. It is found in a part of the time that decoding takes, because values are not
// decoded. So they may still turn out to be broken.
struct StreamOutline {
  StreamDescription description;  // of a kD-tree without bits, ranges and origins, which come after its values
  std::vector<StoredValues> stored;  // an element for each attribute
};
PSPLIT_EXPORT Expected<StreamOutline> outline_stream(Span<const uint8_t> stream);

// Where an attribute is written.
struct AttributePlaces {
  // value_count values. If value_of_point is null, one for each point. Null: the attribute is not wanted.
  std::byte* values = nullptr;
  uint32_t* value_of_point = nullptr;  // the number of each point's value; may be null
  bool integers = false;               // only if the attribute has them
  size_t stride = 0;                   // bytes from one value to the next; 0: tightly packed
};
struct GeometryPlaces {
  void* faces = nullptr;                    // three points for each face, aligned to index_bytes
  std::vector<AttributePlaces> attributes;  // those of the stream, in its order
  // Called after each attribute is written, so that several can share an array value_of_point. May be empty.
  std::function<void(size_t attribute)> written{};
  uint32_t index_bytes = 4;  // or 2, if no point number is larger
};
// Called once the counts are known. `stored` has an element for each attribute.
using PlacesFor =
    std::function<Expected<GeometryPlaces>(const StreamDescription&, Span<const StoredValues> stored)>;

// Decodes a stream to the places that places_for returns, which may throw. Its error is returned.
PSPLIT_EXPORT Status decode_geometry(Span<const uint8_t> stream, const PlacesFor& places_for);

// Gives `geometry` what is known of a stream, and the memory for the rest, not zeroed, which is returned.
// Errors: kInvalidInput if `stored_bytes`, those of the stream, do not justify that much memory.
PSPLIT_EXPORT Expected<GeometryPlaces> allocate_geometry(const StreamDescription& description,
                                                         Span<const StoredValues> stored, bool integers,
                                                         uint64_t stored_bytes, DracoGeometry& geometry);

// ---- What a Draco stream says beside its geometry ----

// A part of a tree of entries. The type of a value is not stored: who wrote it knows it.
struct Metadata {
  std::string name;                                     // unique among the parts of one; "" for the root
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
  uint32_t unique_id = 0;  // of the attribute. The stream may have none with that id
  Metadata metadata;

  friend bool operator==(const AttributeMetadata& a, const AttributeMetadata& b) {
    return a.unique_id == b.unique_id && a.metadata == b.metadata;
  }
};

struct StreamMetadata {
  Metadata geometry;
  std::vector<AttributeMetadata> attributes;  // in the order of the stream; not all attributes have some

  friend bool operator==(const StreamMetadata& a, const StreamMetadata& b) {
    return a.geometry == b.geometry && a.attributes == b.attributes;
  }
};

// Reads the metadata of a Draco mesh or point cloud, bitstreams 1.3 to 2.3. The geometry is not decoded.
// Returns empty metadata if the stream has none. Any bytes may be given. Takes some hundred bytes for each byte
// of metadata at most. Errors: kUnsupported (another bitstream), kInvalidInput (no Draco stream, or metadata
// that end early, contradict themselves, have an empty value, repeat the name of a part, or nest more than a
// thousand times).
// Thread-safe.
PSPLIT_EXPORT Expected<StreamMetadata> read_metadata(Span<const uint8_t> stream);

}  // namespace psplit
