// The CUDA side of psplit, callable from builds that have none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/container/decode_backend.h"

struct CUstream_st;  // what a cudaStream_t points to

namespace psplit {

// True when this build holds the CUDA decoder and the machine has a device and a driver that run it. Else
// *why, where given, is a phrase to show a user: "built without CUDA", "no CUDA-capable device is detected".
PSPLIT_EXPORT bool cuda_available(std::string* why);

// How many multiprocessors the device has that is current; 0 where there is none.
PSPLIT_EXPORT uint32_t cuda_multiprocessors();
// What its maker calls it; empty where there is none.
PSPLIT_EXPORT std::string cuda_device_name();

// Memory of a device, for those who have no allocator of their own.
class PSPLIT_EXPORT CudaMemory {
 public:
  // On the device that is current; aligned for everything. Errors: kUnsupported without a device,
  // kRuntimeFailure where it has not so much.
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
  // Waits for the device, and copies what is at `from` of it to the host.
  static Status download(const void* from, std::span<std::byte> to);

 private:
  CudaMemory(std::byte* data, size_t size) : data_(data), size_(size) {}
  std::byte* data_ = nullptr;
  size_t size_ = 0;
};

// Where an attribute goes: in the type that it was encoded in, or quantized floats as places on their grid, in
// unsigned integers with enough bits.
struct CudaAttribute {
  uint32_t unique_id = 0;  // Draco's, as the extension names it
  ComponentType component_type = ComponentType::kFloat32;
  uint8_t component_count = 3;
  void* values = nullptr;  // on the device: the first point's
  uint32_t stride = 0;     // bytes from one point to the next
  // On the device, or null; of a grid: the float that place 0 of each component is, and what one place is more.
  // Patches whose grid is not that of the first one written are kInvalidInput.
  float* grid = nullptr;
};

// One mesh, or some of its patches: [first, end), where a residue is one more patch, the last.
//
// Stitched, these have the faces and points of the mesh that the directory gives them: indices are the mesh's,
// values begin with the first point that patch `first` owns. Patches that they refer to are decoded as well,
// and not written. A mesh larger than the device is decoded window after window.
//
// Otherwise every patch has the points that it decodes to, those on its border as well: for cluster rendering.
// Faces and points stand patch after patch; indices count from the first point of all.
//
// A stock Draco stream is a container of one patch, if it is said how many points there is room for.
struct CudaPrimitive {
  std::span<const uint8_t> container;  // on the host
  std::vector<CudaAttribute> attributes{};
  void* indices = nullptr;   // on the device and aligned: three for each face of the directory
  uint32_t index_bytes = 4;  // 2 or 4
  bool is_stitched = true;
  uint32_t first = 0, end = 0xffffffff;  // patches
  // On the device, or null; for patches that are not stitched. The box of each, three least and three most of
  // the first attribute's three floats, which must be aligned.
  float* bounds = nullptr;
  uint32_t stream_points = 0;  // of a stock Draco stream the most that there is room for; 0 for a container
  // The container is on the device: start waits for a copy of it on the host, to plan by.
  bool is_on_device = false;
};

// Decodes any number of primitives at once to memory of the device. Its own memory there grows to the largest
// batch, and is kept. Not safe to share between threads; a device may have several.
class PSPLIT_EXPORT CudaDecoder {
 public:
  // For the device that is current, and in the order of `stream`, or of a stream of its own where that is null.
  // Errors: kUnsupported without a device, kRuntimeFailure where CUDA fails.
  static Expected<CudaDecoder> create(CUstream_st* stream = nullptr);
  CudaDecoder(CudaDecoder&&) noexcept;
  ~CudaDecoder();

  // Starts to decode, of which finish is the end: containers must stay where they are until then. Errors:
  // kRuntimeFailure where CUDA fails; all others are for finish.
  Status start(std::span<const CudaPrimitive> primitives);
  // Waits. The first error, with its place: kUsage for what cannot be asked for, kInvalidInput for what is
  // broken, kUnsupported for versions that are not known, kRuntimeFailure where CUDA fails. What is not broken
  // is right nevertheless, but for faces that share a point with a broken patch; of broken patches nothing is
  // promised but that indices are below the number of points, and that nothing else was written to. The same
  // again where nothing was started since, or start failed.
  Status finish();
  // After finish: the first error of a primitive of the batch.
  Status status(size_t primitive) const;
  // After finish: how many points a stock Draco stream has; 0 if it is broken or was refused.
  uint32_t point_count(size_t primitive) const;

  // How much memory of the device it may take beside the results; at first, and at most, nine tenths of what
  // there is. More patches wait for their turn, and come out the same. What all of a batch need, compressed
  // bytes and some for a point and a patch, and what one patch takes on its own, or a quarter of the limit for
  // all of them, is taken in any case.
  void set_memory_limit(uint64_t bytes);

  // Milliseconds of each stage between start and finish, as the device's events measure them. Measuring is off
  // at first; each call is for what was decoded since the last.
  void measure(bool on);
  std::vector<std::pair<std::string, double>> take_times();

 private:
  struct Implementation;
  explicit CudaDecoder(std::unique_ptr<Implementation> implementation);
  std::unique_ptr<Implementation> implementation_;
};

// All tasks at once, on the device that is current when it is first used. Takes at most so many bytes of the
// device, and at most nine tenths of what is free then, of which 0 means all: more is decoded in parts. Safe to
// call from several threads, which wait for each other; memory of the device is kept for the next call.
// Attributes must be asked for in the types that they were encoded in. Errors: kUnsupported without a device
// and for other types; kRuntimeFailure where the device fails.
PSPLIT_EXPORT DecodeBackend cuda_backend(uint64_t memory_limit = 0);

}  // namespace psplit
