// Loads primitives of PSPLIT_mesh_draco_patches and of KHR_draco_mesh_compression into memory of the caller's:
// for loaders of any kind, whatever library reads their JSON. What knows nothing of a stream but its bytes, a
// .drc file, is decoded by decode_draco (src/cpu/cpu_backend.h).
//
//   PrimitiveSource source;                     // from the primitive's JSON
//   source.bytes = ...;                         // of extensions.PSPLIT_mesh_draco_patches.bufferView
//   source.compression = ...;                   // kDraco for KHR_draco_mesh_compression
//   source.attributes.push_back({"POSITION", 0, ComponentType::kFloat32, 3, false});
//   Expected<CompressedPrimitive> primitive = CompressedPrimitive::open(source);
//   if (!primitive) return primitive.status();  // to_string() says what and where
//   std::vector<uint32_t> indices(3 * primitive->face_count());
//   std::vector<float> positions(3 * primitive->point_count());
//   Status status = primitive->decode({std::as_writable_bytes(std::span(indices)), 4,
//                                      {{std::as_writable_bytes(std::span(positions))}}});
//
// A point is a glTF vertex. Any bytes may be given. Memory is taken in proportion to them: of what a container
// claims, CompressedPrimitive::open refuses what its bytes do not justify.
//
//   limit(n)   64 MiB and 4096 bytes for each of n bytes
//   open       no more than 128 bytes for each byte of the container
//   sizes      what others take memory by: indices of 4 bytes and the values of all attributes together are no
//              more than limit(container)
//   decode     each thread no more than limit(stream) for each of the three streams that it decodes at once,
//              kept for the next call; honest streams take some dozen bytes for each of their own faces and
//              values. Beside that, 12 bytes for each point, 8 for each corner of a face that is a reference
//              (and as many again while they are counted up), 128 for each byte of the container, and where an
//              accessor asks for another type than was encoded, the patch's values once more
//
// Backends that only make meshes (libdraco's, CUDA's) hold each result once more until it is copied.
//
// Errors are kInvalidInput (broken bytes, or JSON that contradicts them), kUnsupported (versions, among them
// Draco bitstreams before 2.2; component types), kUsage (buffers that do not do, a patch that there is none
// of), kCancelled, and what the backend has. Their place names the patch, where it is one's fault. After an
// error the buffers hold anything, but nothing was written outside of them.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "src/container/decode_backend.h"
#include "src/mesh/mesh.h"
#include "src/status.h"

namespace psplit {

enum class Compression : uint8_t {
  kPatches,  // PSPLIT_mesh_draco_patches: a container of patches
  kDraco,    // KHR_draco_mesh_compression: one Draco mesh stream, sequential or Edgebreaker, of bitstream 2.2
};

// What the JSON of a primitive says.
struct PrimitiveSource {
  std::span<const uint8_t> bytes;  // of the extension's buffer view
  // Those wanted of the extension's `attributes`: their unique ids are there, all else is their accessors'.
  std::vector<AttributeRequest> attributes{};
  // `count` of the attributes' accessors and of the indices' one; 0 for what shall not be compared. An
  // Edgebreaker stream does not say how many points it has: where point_count is 0, open decodes it to count
  // them.
  uint64_t point_count = 0, index_count = 0;
  Compression compression = Compression::kPatches;
};

// How many bytes the indices and values of all primitives of a model may take together that are stored in so
// many bytes: loaders refuse models that claim more.
PSPLIT_EXPORT uint64_t most_result_bytes(uint64_t stored_bytes);

// Where an attribute goes: a value for each point, `stride` bytes from one to the next, or tightly packed where
// that is 0. Of any alignment; what lies between two values is left alone.
struct AttributeBuffer {
  std::span<std::byte> bytes;
  size_t stride = 0;
};

// Memory of the caller's, no two parts of which overlap.
struct PrimitiveBuffers {
  std::span<std::byte> indices;               // three for each face, tightly packed, aligned to their size
  uint32_t index_bytes = 4;                   // 2, where there are no more than 65,535 points, or 4
  std::vector<AttributeBuffer> attributes{};  // one for each of PrimitiveSource's
};

struct LoadOptions {
  const DecodeBackend* backend = nullptr;  // null: the CPU
  int thread_count = 0;                    // 0: as many as the machine has
  // Called from any thread, and from several at once, with how many steps are done of how many: patches on the
  // CPU, primitives with other backends.
  Progress progress{};
  // Where it is given and becomes true, decoding ends with kCancelled: on the CPU before the next patch of each
  // thread, with other backends when they are done with all.
  const std::atomic<bool>* stop = nullptr;
};

// One stream of a container, or the only one of KHR_draco_mesh_compression: the unit of random access.
struct PatchSizes {
  uint32_t face_count = 0;
  uint32_t point_count = 0;  // as it decodes on its own, those included that other patches own
  uint32_t stream_bytes = 0;
  // In the whole primitive, its faces and the points that it owns stand together, in decoded order.
  uint32_t first_face = 0, first_owned_point = 0, owned_point_count = 0;
};

struct PrimitiveLoad;

// Stored bytes that were looked at. Cheap to copy; safe to share between threads.
class PSPLIT_EXPORT CompressedPrimitive {
 public:
  // Checks the directory and the streams' headers. source.bytes must stay where they are as long as there is
  // a copy of what comes back.
  static Expected<CompressedPrimitive> open(PrimitiveSource source);

  std::span<const uint8_t> bytes() const;
  Compression compression() const;
  uint32_t point_count() const;
  uint32_t face_count() const;
  // 2 where that is enough for all points, else 4.
  uint32_t least_index_bytes() const;
  // How many bytes the values of an attribute take, tightly packed.
  uint64_t value_bytes(size_t attribute) const;
  const std::vector<AttributeRequest>& attributes() const;

  // One for kDraco. Where has_residue, the last patch is the residue: the faces and points that others cannot
  // carry. Containers of version 1 state no bounds.
  uint32_t patch_count() const;
  bool has_residue() const;
  PatchSizes patch(uint32_t number) const;  // number < patch_count()

  // The whole primitive, stitched.
  Status decode(const PrimitiveBuffers& out, const LoadOptions& options = {}) const;
  // One patch with the faces and points of its PatchSizes: indices count from its own first point. No other
  // patch's stream is read.
  Status decode_patch(uint32_t number, const PrimitiveBuffers& out, const LoadOptions& options = {}) const;

 private:
  friend std::vector<Status> decode_primitives(std::span<const PrimitiveLoad>, const LoadOptions&);
  struct State;
  explicit CompressedPrimitive(std::shared_ptr<const State> state) : state_(std::move(state)) {}
  std::shared_ptr<const State> state_;
};

// Many primitives at once, so that threads or a device are busy with all. A status for each, in their order;
// one's error is no other's.
struct PrimitiveLoad {
  CompressedPrimitive primitive;
  PrimitiveBuffers out;
};
PSPLIT_EXPORT std::vector<Status> decode_primitives(std::span<const PrimitiveLoad> loads,
                                                    const LoadOptions& options = {});

}  // namespace psplit
