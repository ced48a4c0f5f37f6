// Loads primitives of PSPLIT_mesh_draco_patches and of KHR_draco_mesh_compression into the caller's memory. Any
// library may read the JSON. decode_draco (decode.h) decodes .drc files, which have no JSON.
//
//   PrimitiveSource source;                     // from the primitive's JSON
//   source.bytes = ...;                         // of extensions.PSPLIT_mesh_draco_patches.bufferView
//   source.compression = ...;                   // kDraco for KHR_draco_mesh_compression
//   source.attributes.push_back({"POSITION", 0, ComponentType::kFloat32, 3, false});
//   source.attributes.push_back({name_of_target(0, "POSITION"), 1, ComponentType::kFloat32, 3, false});
//   Expected<CompressedPrimitive> primitive = CompressedPrimitive::open(source);
//   if (!primitive) return primitive.status();  // to_string() says what is wrong and where
//   std::vector<uint32_t> indices(3 * primitive->face_count());
//   std::vector<float> positions(3 * primitive->point_count()), deltas(positions);
//   Status status = primitive->decode({indices, 4, {{positions}, {deltas}}});
//
// A point is a glTF vertex. All functions are safe for untrusted bytes. Memory is proportional to their number:
// CompressedPrimitive::open refuses counts that the bytes do not justify.
//
//   limit(n)   64 MiB, and 4096 bytes for each of n bytes
//   open       at most 144 bytes for each byte of the container. Condensed streams share tables: at most 48 KiB
//              for each of these, and there are at most 768
//   counts     callers take memory according to them: indices of 4 bytes and the values of all attributes are
//              together at most limit(container)
//   decode     each thread takes at most limit(stream) for each of the three streams that it decodes at
//              once, and keeps it for the next call until release_scratch (decode.h). Streams
//              that an encoder wrote take some dozen bytes for each of their faces and values. In addition: 12
//              bytes for each point; 8 for each face corner that is a reference, and as much again while their
//              number grows; 128 for each byte of the container. If an accessor declares another type than was
//              encoded, also the patch's values once more
//
// libdraco's backend first decodes each patch of a container to a mesh of its own. CUDA's backend needs device
// memory for the results.
//
// Errors are kInvalidInput (broken bytes, or JSON that contradicts them), kUnsupported (component types, and
// versions, such as Draco bitstreams before 2.2), kUsage (buffers that do not fit, a patch that does not
// exist), kCancelled, and the errors of the backend. The place of an error in a patch names the patch. After an
// error the contents of the buffers are unspecified, but nothing was written outside of them.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "psplit/base.h"
#include "psplit/decode.h"
#include "psplit/mesh.h"

namespace psplit {

enum class Compression : uint8_t {
  kPatches,  // PSPLIT_mesh_draco_patches: a container of patches
  kDraco,    // KHR_draco_mesh_compression: one Draco mesh stream, sequential or Edgebreaker, of bitstream 2.2
};

// A compressed primitive as its JSON describes it.
struct PrimitiveSource {
  Span<const uint8_t> bytes;  // of the extension's buffer view
  // The wanted ones of the extension's `attributes`, with their ids. Types come from the accessors.
  std::vector<AttributeRequest> attributes{};
  // The accessors' `count`; 0: unknown. `open` compares them with the bytes. An Edgebreaker stream of kDraco
  // states only an upper bound of its points, so its point_count is compared when it is decoded, and nothing is
  // written if it is wrong; without point_count, `open` decodes the faces of the stream to count its points.
  uint64_t point_count = 0, index_count = 0;
  Compression compression = Compression::kPatches;
  // Decodes streams of kDraco before bitstream 2.2, in place of the backend: older_streams() of
  // psplit::encoder, if that was built with libdraco. Null: such streams are kUnsupported. `open` decodes such
  // a stream to count its points. Its memory is not limited, and its progress is not reported. Must outlive all
  // copies of the primitive.
  const OlderStreams* older = nullptr;
};

// The most bytes of indices and values that a model of `stored_bytes` compressed bytes may claim, in all its
// primitives together. Loaders refuse models that claim more.
PSPLIT_EXPORT uint64_t most_result_bytes(uint64_t stored_bytes);

struct LoadOptions {
  const DecodeBackend* backend = nullptr;  // null: the CPU
  // Null: a pool for this call, with a thread for each processor. Reuse a pool for frequent calls.
  const ThreadPool* pool = nullptr;
  // Called from any thread, also from several at once, with the number of finished steps and their total. Steps
  // are patches on the CPU, and primitives with other backends. If it throws, its exception becomes the error
  // of all primitives of the call.
  Progress progress{};
  // Decoding ends with kCancelled when it becomes true: on the CPU before the next patch of each thread, with
  // libdraco before the next primitive, with CUDA before the next batch. May be null.
  const std::atomic<bool>* stop = nullptr;
};

// One stream of a container, or the only one of KHR_draco_mesh_compression: the unit of random access.
struct PatchSizes {
  uint32_t face_count = 0;
  uint32_t point_count = 0;  // as it decodes alone, with the points that other patches own
  uint32_t stream_bytes = 0;
  // The patch's faces, and the points that it owns, are consecutive in the whole primitive, in decoded order.
  uint32_t first_face = 0, first_owned_point = 0, owned_point_count = 0;
};

struct PrimitiveLoad;

// A primitive whose bytes are opened: directory and headers are checked. Cheap to copy, thread-safe.
class PSPLIT_EXPORT CompressedPrimitive {
 public:
  // Checks the directory and the streams' headers. source.bytes must outlive all copies of the result.
  static Expected<CompressedPrimitive> open(PrimitiveSource source);
  // A primitive with the same opened bytes, but other wanted attributes. Errors: as open.
  Expected<CompressedPrimitive> with_attributes(std::vector<AttributeRequest> attributes) const;

  Span<const uint8_t> bytes() const;
  Compression compression() const;
  uint32_t point_count() const;
  uint32_t face_count() const;
  // Bytes of an index: 2 if all point numbers fit, otherwise 4.
  uint32_t least_index_bytes() const;
  // Bytes of all values of an attribute, tightly packed.
  uint64_t value_bytes(size_t attribute) const;
  const std::vector<AttributeRequest>& attributes() const;

  // 1 for kDraco. If has_residue(), the last patch is the residue: the faces and points that Edgebreaker cannot
  // carry.
  uint32_t patch_count() const;
  bool has_residue() const;
  PatchSizes patch(uint32_t number) const;  // number < patch_count()
  // The bounding box of each patch's positions if the container stores boxes, otherwise an empty vector.
  // Errors: kInvalidInput for invalid boxes. Decoding does not read them.
  Expected<std::vector<PatchBox>> patch_boxes() const;

  // The decoder that replaces the backend if the bitstream is older than 2.2; otherwise null.
  const OlderStreams* older() const;

  // The opened bytes for decoders: CudaPrimitive (cuda.h) and DecodeTask point to it. Lives as long as any copy
  // of this object.
  const PatchContainer& container() const;

  // Decodes the whole primitive, stitched.
  Status decode(const PrimitiveBuffers& out, const LoadOptions& options = {}) const;
  // Decodes one patch, with the faces and points of its PatchSizes. Indices count from the patch's first point.
  // Does not read the streams of other patches.
  Status decode_patch(uint32_t number, const PrimitiveBuffers& out, const LoadOptions& options = {}) const;

 private:
  struct State;
  explicit CompressedPrimitive(std::shared_ptr<const State> state) : state_(std::move(state)) {}
  std::shared_ptr<const State> state_;
};

// Decodes many primitives at once, to keep all threads, or a device, busy. Returns a status for each, in their
// order. An error of one primitive does not affect others.
struct PrimitiveLoad {
  CompressedPrimitive primitive;
  PrimitiveBuffers out;
};
PSPLIT_EXPORT std::vector<Status> decode_primitives(Span<const PrimitiveLoad> loads,
                                                    const LoadOptions& options = {});

}  // namespace psplit
