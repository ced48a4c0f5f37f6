// The decoder for CUDA devices. In builds without CUDA, functions that may fail return kUnsupported, as on a
// machine without a device.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "psplit/base.h"
#include "psplit/decode.h"

struct CUstream_st;  // what a cudaStream_t points to

namespace psplit {

// Returns whether this build contains the CUDA decoder, and the machine has a device and a driver that run it.
// If not, *why (unless `why` is null) gets a phrase for a user: "built without CUDA", "no CUDA-capable device
// is detected".
PSPLIT_EXPORT bool cuda_available(std::string* why);

// The number of multiprocessors of the current device; 0 without a device.
PSPLIT_EXPORT uint32_t cuda_multiprocessors();
// The name of the current device; empty without a device.
PSPLIT_EXPORT std::string cuda_device_name();

// Owns memory of a device, for callers without an allocator of their own.
class PSPLIT_EXPORT CudaMemory {
 public:
  // Allocates on the current device, aligned for any type. Errors: kUnsupported without a device,
  // kRuntimeFailure if it does not have that much memory.
  static Expected<CudaMemory> allocate(size_t bytes);
  CudaMemory(CudaMemory&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  CudaMemory& operator=(CudaMemory&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~CudaMemory();

  std::byte* data() const { return data_; }
  size_t size() const { return size_; }
  // Waits for the device, and copies from its memory to the host's.
  static Status download(const void* from, WritableBytes to);

 private:
  CudaMemory(std::byte* data, size_t size) : data_(data), size_(size) {}
  std::byte* data_ = nullptr;
  size_t size_ = 0;
};

// Where an attribute goes. The type must be the encoded one. For floats on a quantization grid it may instead
// be an unsigned integer type with enough bits: the values are then places on the grid.
struct CudaAttribute {
  uint32_t unique_id = 0;  // Draco's; the extension states it
  ComponentType component_type = ComponentType::kFloat32;
  uint8_t component_count = 3;
  void* values = nullptr;  // on the device: the first point's
  uint32_t stride = 0;     // bytes from one point to the next
  // Memory of the device that receives the grid, or null: the float at place 0 of each component, and then the
  // step from one place to the next. It is kInvalidInput if a patch has another grid than the first written
  // one.
  float* grid = nullptr;
};

// One mesh, or its patches [first, end). A residue counts as one more patch, the last.
//
// Stitched patches have the faces and points of the mesh that the directory gives them. Indices are the mesh's.
// Values begin with the first point that patch `first` owns. Other patches that these patches refer to are
// decoded as well, but not written. So a mesh larger than the device's memory can be decoded window by window.
//
// Patches that are not stitched keep all points that they decode to, including the shared points on their
// borders: for cluster rendering. The faces and points of each patch follow the previous patch's. Indices count
// from the first patch's first point.
//
// Condensed patches are decoded on the device like others. The tables of their container's head are uploaded
// with every batch, even if the container is already at device_bytes.
//
// A stock Draco stream counts as a container of one patch. The buffers must have room for the points that its
// container counts.
struct CudaPrimitive {
  const PatchContainer* container = nullptr;  // an opened primitive's: CompressedPrimitive::container
  const uint8_t* device_bytes = nullptr;      // the container's bytes on the device; null: they are uploaded
  std::vector<CudaAttribute> attributes{};
  void* indices = nullptr;   // on the device and aligned: three for each face of the directory
  uint32_t index_bytes = 4;  // 2 or 4
  bool is_stitched = true;
  uint32_t first = 0, end = 0xffffffff;  // patches
  // On the device, or null; only for patches that are not stitched. Receives the box of each patch: the minima,
  // then the maxima, of the first attribute, which must have three floats, aligned.
  float* bounds = nullptr;
};

// Decodes any number of primitives at once to memory of the device. Its own device memory grows to the needs of
// the largest batch, and is kept. Not thread-safe; a device may have several decoders.
class PSPLIT_EXPORT CudaDecoder {
 public:
  // Decodes on the current device, in the order of `stream`, or of a stream of its own if `stream` is null.
  // Errors: kUnsupported without a device, kRuntimeFailure if CUDA fails.
  static Expected<CudaDecoder> create(CUstream_st* stream = nullptr);
  CudaDecoder(CudaDecoder&&) noexcept;
  ~CudaDecoder();

  // Starts to decode. Containers and their bytes must stay where they are until finish. The threads of `pool`,
  // unless it is null, plan meshes of thousands of patches. Errors: kRuntimeFailure if CUDA fails. finish
  // returns all other errors.
  Status start(Span<const CudaPrimitive> primitives, const ThreadPool* pool = nullptr);
  // Waits, and returns the first error with its place: kUsage for an impossible request, kInvalidInput for
  // broken streams, kUnsupported for types other than the encoded ones, kRuntimeFailure if CUDA fails. Intact
  // patches are still decoded correctly, with two exceptions: faces that share a point with a broken patch, and
  // condensed patches that take values at their border from a broken patch. These are broken as well. Even in
  // broken patches, indices are below the number of points, and nothing was written outside of the buffers.
  // Returns the previous result again if nothing was started since, or if start failed.
  Status finish();
  // After finish: the first error of this primitive of the batch.
  Status status(size_t primitive) const;
  // After finish: the number of points of a stock Draco stream; 0 after an error.
  uint32_t point_count(size_t primitive) const;

  // Limits the device memory that decoding takes beside the results. The default, and the maximum, is nine
  // tenths of the free memory. If a batch needs more, some patches wait for others; the results stay the same.
  // Two amounts may exceed the limit: the compressed bytes of a batch with the tables of condensed patches and
  // some bytes for each point and patch, and the larger of one patch's memory and a quarter of the limit.
  void set_memory_limit(uint64_t bytes);

  // measure turns timing on or off (initially off). take_times returns the milliseconds of each stage between
  // start and finish, measured by the device's events, since its last call.
  void measure(bool on);
  std::vector<std::pair<std::string, double>> take_times();

 private:
  struct Implementation;
  explicit CudaDecoder(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

// A batch that is planned once and decoded any number of times, in memory and on streams that the caller
// chooses. Made for engines: no call except finish waits for the device.
//
//   CudaBatch batch = CudaBatch::plan(primitives);   // on the host
//   status = batch.prepare();                        // takes memory
//   status = batch.enqueue(stream);                  // copies and launches only
//   ... batch.poll(), or other work that is enqueued after it
//   status = batch.finish();
//
// Not thread-safe. Enqueue a batch again only when it is done, or on the same stream. Containers, their bytes,
// and the device memory that the primitives name must outlive the batch. See docs/cuda.md.
class PSPLIT_EXPORT CudaBatch {
 public:
  // Plans on the host, without a device. Decoding takes at most `memory_limit` bytes of the device beside the
  // results, with the exceptions that CudaDecoder::set_memory_limit names; a lower limit takes longer. The
  // threads of `pool`, unless it is null, plan meshes of thousands of patches. An impossible request becomes
  // the error of its primitive: see status.
  static CudaBatch plan(Span<const CudaPrimitive> primitives, uint64_t memory_limit = ~uint64_t{0},
                        const ThreadPool* pool = nullptr);
  CudaBatch(CudaBatch&&) noexcept;
  // Waits for the last upload and enqueue, unless they were captured: after that, the graph must not be
  // launched.
  ~CudaBatch();

  // The device memory that decoding takes, in bytes.
  uint64_t workspace_bytes() const;

  // Makes the batch ready on the current device. `workspace` is device memory of workspace_bytes() bytes,
  // aligned to 256. Nothing else may use it while the batch is decoded; several batches may share it, one after
  // the other. If it is null, the batch allocates its own. Pins host memory for all bytes to be uploaded, and
  // copies them there, also with the threads of `pool` unless it is null. Another workspace may be prepared
  // when the batch is done. Errors: kUnsupported without a device, kUsage for a wrong alignment or another
  // device than before, kRuntimeFailure if there is too little memory.
  Status prepare(void* workspace = nullptr, const ThreadPool* pool = nullptr);

  // Uploads tables and compressed bytes now, so that enqueue does not. From then on, nothing else may write to
  // the workspace as long as the batch is used. If `stream` is being captured, the graph uploads them instead,
  // and so do later calls of enqueue. Errors: as enqueue.
  Status upload(CUstream_st* stream);

  // Decodes in the order of `stream`, which may be CUDA's default stream (null). Only makes asynchronous copies
  // from and to pinned memory and launches kernels, so that it can be captured in a CUDA graph, which can be
  // launched as long as the batch lives. CUDA's default stream cannot be captured. The default stream takes no
  // work while a stream is captured that was not created as non-blocking. Errors: kUsage before prepare,
  // kRuntimeFailure if CUDA fails. After an error no work of the batch runs.
  Status enqueue(CUstream_st* stream);

  // Whether the last enqueue is done. If it was captured, the batch cannot know, and returns true. Errors:
  // kUsage if there was no enqueue, kRuntimeFailure if CUDA failed.
  Expected<bool> poll() const;

  // Waits for the last enqueue, and returns the first error with its place, like CudaDecoder::finish. If it was
  // captured, does not wait: the graph's last launch must be done. Nothing is decoded twice: kRuntimeFailure if
  // a patch needs more memory than was planned, which only patches with unrequested attributes do; CudaDecoder
  // can decode these.
  Status finish();
  // Returns the first error of the primitive after finish, and before it an error if the request is impossible.
  Status status(size_t primitive) const;
  // After finish: the number of points of a stock Draco stream; 0 after an error.
  uint32_t point_count(size_t primitive) const;

 private:
  struct Implementation;
  explicit CudaBatch(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

// Makes the driver load all kernels to the current device, and allocate their stacks, which otherwise happens
// at a kernel's first launch. Takes minutes on a device for which this build contains only PTX. Thread-safe,
// like all functions of this header that belong to no object. Errors: kUnsupported without a device,
// kRuntimeFailure if CUDA fails.
PSPLIT_EXPORT Status cuda_warm_up();

// Decodes all tasks at once, on the device that is current at the first call. Takes at most `memory_limit`
// bytes of the device, and at most nine tenths of its free memory; 0 means no other limit. Tasks that need more
// are decoded in parts. Thread-safe: threads wait for each other. Device memory is kept for the next call.
// Attributes must be requested in their encoded types. Errors: kUnsupported without a device, for other types,
// and for a stream of more than 1,000,000 faces, whose kernel would run longer than some systems allow;
// kRuntimeFailure if the device fails.
PSPLIT_EXPORT DecodeBackend cuda_backend(uint64_t memory_limit = 0);

}  // namespace psplit
