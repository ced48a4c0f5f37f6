// A CUDA device as the Device of batch_decoder.h: one stream of work, and memory that grows.
#pragma once

#include <cuda_runtime.h>

#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "decoder_cuda/warp_lanes.cuh"
#include "psplit/base.h"

namespace psplit {

// The status of a call of the runtime, whose name `call` is. `bytes` is the amount of memory that it asked for.
inline Status cuda_status(cudaError_t error, const char* call, size_t bytes = 0) {
  if (error == cudaSuccess) return {};
  (void)cudaGetLastError();  // the error also remains the runtime's last error
  const std::string amount = bytes > 0 ? " of " + std::to_string(bytes) + " bytes" : "";
  return runtime_failure(std::string("CUDA: ") + call + amount + ": " + cudaGetErrorString(error));
}
// For calls whose failure changes nothing, such as releasing a resource.
inline void ignore(cudaError_t error) {
  if (error != cudaSuccess) (void)cudaGetLastError();
}

// The most threads and blocks of a multiprocessor, for the architecture that is compiled. Source: the CUDA
// programming guide's table of compute capabilities.
struct Multiprocessor {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ < 800
  static constexpr uint32_t kThreads = 1024, kBlocks = 16;
#elif defined(__CUDA_ARCH__) && (__CUDA_ARCH__ == 860 || __CUDA_ARCH__ == 870)
  static constexpr uint32_t kThreads = 1536, kBlocks = 16;
#elif defined(__CUDA_ARCH__) && (__CUDA_ARCH__ == 890 || __CUDA_ARCH__ >= 1200)
  static constexpr uint32_t kThreads = 1536, kBlocks = 24;
#else
  static constexpr uint32_t kThreads = 2048, kBlocks = 32;
#endif
};

// The number of blocks that a multiprocessor takes, but at most `wanted`.
constexpr uint32_t blocks_at_once(uint32_t wanted, uint32_t threads) {
  return std::min({wanted, Multiprocessor::kBlocks, Multiprocessor::kThreads / threads});
}

// The warps of run_threads that a multiprocessor runs at once, and that limit their registers.
constexpr uint32_t kThreadWarps = 32;

// The first `lanes` lanes of each warp take an item each.
template <typename Body>
__global__ void __launch_bounds__(WarpLanes::size(), blocks_at_once(kThreadWarps, WarpLanes::size()))
    run_threads(uint32_t count, uint32_t lanes, Body body) {
  const uint32_t lane = threadIdx.x % WarpLanes::size();
  const uint32_t i = (blockIdx.x * blockDim.x + threadIdx.x) / WarpLanes::size() * lanes + lane;
  if (lane < lanes && i < count) body(i);
}

// The blocks of run_warps that a multiprocessor runs at once. They limit the registers of a thread to 64, or to
// 48 for a body that is small: most of the time such kernels wait for memory, so more warps are faster.
constexpr uint32_t kWarpsOfBlock = 4;
template <typename Body>
concept SmallBody = requires {
  Body::kIsSmall;
};
template <typename Body>
constexpr uint32_t kBlocksAtOnce = SmallBody<Body> ? 10 : 8;

// Whole warps return together, so no lane waits for a lane that has returned.
template <typename Body>
__global__ void __launch_bounds__(kWarpsOfBlock* WarpLanes::size(),
                                  blocks_at_once(kBlocksAtOnce<Body>, kWarpsOfBlock* WarpLanes::size()))
    run_warps(uint32_t count, uint32_t, Body body) {
  const uint32_t i = (blockIdx.x * blockDim.x + threadIdx.x) / WarpLanes::size();
  if (i < count) body(WarpLanes(), i);
}

// Makes a device current during its lifetime.
class CurrentDevice {
 public:
  explicit CurrentDevice(int device) {
    ignore(cudaGetDevice(&before_));
    if (before_ != device) ignore(cudaSetDevice(device));
    device_ = device;
  }
  ~CurrentDevice() {
    if (before_ != device_) ignore(cudaSetDevice(before_));
  }
  CurrentDevice(const CurrentDevice&) = delete;
  CurrentDevice& operator=(const CurrentDevice&) = delete;

 private:
  int before_ = 0, device_ = 0;
};

// Movable. Its arrays must not outlive it.
class CudaDevice {
  // The host's memory is pinned, so that copies to the device are asynchronous.
  template <typename T, bool kOnHost>
  class Memory {
   public:
    Memory() = default;
    Memory(Memory&& other) noexcept
        : data_(std::exchange(other.data_, nullptr)), count_(std::exchange(other.count_, 0)) {}
    Memory& operator=(Memory&& other) noexcept {
      std::swap(data_, other.data_);
      std::swap(count_, other.count_);
      return *this;
    }
    ~Memory() { release(); }

    // Loses the contents if the memory grows.
    Status reserve(size_t count) {
      if (count <= count_) return {};
      release();
      void* memory = nullptr;
      const size_t bytes = count * sizeof(T);
      Status status = kOnHost ? cuda_status(cudaMallocHost(&memory, bytes), "cudaMallocHost", bytes)
                              : cuda_status(cudaMalloc(&memory, bytes), "cudaMalloc", bytes);
      if (!status.ok()) return status;
      data_ = static_cast<T*>(memory);
      count_ = count;
      return status;
    }
    T* data() const { return data_; }
    size_t size() const { return count_; }

   private:
    // Without memory there may be no device, and the runtime must not look for one.
    void release() {
      if (data_ != nullptr) ignore(kOnHost ? cudaFreeHost(data_) : cudaFree(data_));
      data_ = nullptr;
      count_ = 0;
    }

    T* data_ = nullptr;
    size_t count_ = 0;
  };

 public:
  template <typename T>
  using Array = Memory<T, false>;
  template <typename T>
  using HostArray = Memory<T, true>;

  // The purpose of launches.
  enum class Purpose : uint8_t {
    kWork,
    kLoad,     // kernels are launched for no items, so that the driver has them ready
    kMeasure,  // kernels are not launched: see local_bytes
  };

  // Works on `stream`, which must outlive it, or on a stream of its own if that is null.
  static Expected<CudaDevice> create(cudaStream_t stream) {
    if (stream != nullptr) return on(stream);
    Expected<CudaDevice> device = on(nullptr);
    if (!device) return device;
    Status status =
        cuda_status(cudaStreamCreateWithFlags(&device->stream_, cudaStreamNonBlocking), "cudaStreamCreate");
    if (!status.ok()) return status;
    device->owns_stream_ = true;
    return device;
  }
  // Works on `stream`; null is CUDA's default stream.
  static Expected<CudaDevice> on(cudaStream_t stream) {
    CudaDevice device;
    int number = 0, multiprocessors = 0;
    Status known = cuda_status(cudaGetDevice(&number), "cudaGetDevice");
    if (known.ok())
      known = cuda_status(cudaDeviceGetAttribute(&multiprocessors, cudaDevAttrMultiProcessorCount, number),
                          "cudaDeviceGetAttribute");
    if (!known.ok()) return known;
    device.multiprocessors_ = static_cast<uint32_t>(multiprocessors);
    device.stream_ = stream;
    return Expected<CudaDevice>(std::move(device));
  }
  CudaDevice(CudaDevice&& other) noexcept
      : stream_(std::exchange(other.stream_, nullptr)),
        multiprocessors_(other.multiprocessors_),
        purpose_(other.purpose_),
        local_bytes_(other.local_bytes_),
        local_memory_(other.local_memory_),
        owns_stream_(other.owns_stream_),
        measures_(other.measures_),
        marks_(std::exchange(other.marks_, {})),
        mark_count_(std::exchange(other.mark_count_, 0)) {}
  CudaDevice& operator=(CudaDevice&&) = delete;
  ~CudaDevice() {
    for (const Mark& mark : marks_)
      if (mark.event != nullptr) ignore(cudaEventDestroy(mark.event));
    if (owns_stream_ && stream_ != nullptr) ignore(cudaStreamDestroy(stream_));
  }

  template <typename T>
  Status upload(T* to, const T* from, size_t count) {
    if (count == 0) return {};
    return cuda_status(cudaMemcpyAsync(to, from, count * sizeof(T), cudaMemcpyHostToDevice, stream_),
                       "cudaMemcpyAsync to the device");
  }
  template <typename T>
  Status download(T* to, const T* from, size_t count) {
    if (count == 0) return {};
    return cuda_status(cudaMemcpyAsync(to, from, count * sizeof(T), cudaMemcpyDeviceToHost, stream_),
                       "cudaMemcpyAsync to the host");
  }
  // A warp waits for the slowest of its lanes, and steps wait for memory most of the time. So a few items on
  // each of many warps are faster than 32 items on each of few warps. More items than kMostAtOnce on a warp
  // lose their lines from the first cache before they need them again: then warps follow each other, about the
  // same number each time.
  template <typename Body>
  Status launch_threads(uint32_t count, uint32_t busy, const Body& body) {
    constexpr uint32_t kMostAtOnce = 5;
    const uint32_t warps = multiprocessors_ * kThreadWarps, turns = busy / (warps * kMostAtOnce) + 1;
    const uint32_t lanes = std::clamp((busy / turns + warps) / warps, 1u, WarpLanes::size());
    return launch(run_threads<Body>, (count + lanes - 1) / lanes, WarpLanes::size(), count, lanes, body);
  }
  template <typename Body>
  Status launch_warps(uint32_t count, const Body& body) {
    constexpr uint32_t kLanes = WarpLanes::size();
    return launch(run_warps<Body>, (count + kWarpsOfBlock - 1) / kWarpsOfBlock, kWarpsOfBlock * kLanes, count,
                  kLanes, body);
  }
  // Without the memory for the kernels' stacks, which the driver takes when a kernel is launched. 0 if CUDA
  // fails.
  uint64_t free_memory() const {
    size_t free = 0, total = 0;
    ignore(cudaMemGetInfo(&free, &total));
    return free - std::min<uint64_t>(free, local_memory_);
  }
  Status wait() { return cuda_status(cudaStreamSynchronize(stream_), "cudaStreamSynchronize"); }

  uint32_t multiprocessors() const { return multiprocessors_; }
  void set_purpose(Purpose purpose) { purpose_ = purpose; }
  // The largest stack of a thread, of the kernels that were launched to measure it.
  uint64_t local_bytes() const { return local_bytes_; }
  // The memory that the driver may take for stacks, in addition to the memory that is free now.
  void set_local_memory(uint64_t bytes) { local_memory_ = bytes; }

  // Marks are recorded only if measuring is on.
  void measure(bool on) { measures_ = on; }
  void mark(const char* stage) {
    if (!measures_) return;
    if (mark_count_ == marks_.size()) {
      marks_.push_back({});
      ignore(cudaEventCreate(&marks_.back().event));
    }
    marks_[mark_count_].stage = stage;
    ignore(cudaEventRecord(marks_[mark_count_++].event, stream_));
  }
  // The milliseconds from each mark to the next since the last call; call wait first.
  std::vector<std::pair<const char*, float>> take_times() {
    std::vector<std::pair<const char*, float>> times;
    for (size_t i = 0; i + 1 < mark_count_; ++i) {
      float ms = 0;
      ignore(cudaEventElapsedTime(&ms, marks_[i].event, marks_[i + 1].event));
      times.emplace_back(marks_[i].stage, ms);
    }
    mark_count_ = 0;
    return times;
  }

 private:
  struct Mark {
    cudaEvent_t event = nullptr;
    const char* stage = "";
  };

  CudaDevice() = default;

  // Not <<<>>>: its error would be in the runtime's last one, which may be the caller's.
  template <typename Body>
  Status launch(void (*kernel)(uint32_t, uint32_t, Body), uint32_t blocks, uint32_t threads, uint32_t count,
                uint32_t lanes, Body body) {
    if (blocks == 0) return {};
    const void* const function = reinterpret_cast<const void*>(kernel);
    if (purpose_ == Purpose::kMeasure) {
      cudaFuncAttributes attributes{};
      Status status = cuda_status(cudaFuncGetAttributes(&attributes, function), "cudaFuncGetAttributes");
      local_bytes_ = std::max<uint64_t>(local_bytes_, attributes.localSizeBytes);
      return status;
    }
    if (purpose_ == Purpose::kLoad) count = 0;
    void* arguments[] = {&count, &lanes, &body};
    return cuda_status(cudaLaunchKernel(function, blocks, threads, arguments, 0, stream_), "cudaLaunchKernel");
  }

  cudaStream_t stream_ = nullptr;
  uint32_t multiprocessors_ = 1;
  Purpose purpose_ = Purpose::kWork;
  uint64_t local_bytes_ = 0, local_memory_ = 0;
  bool owns_stream_ = false, measures_ = false;
  std::vector<Mark> marks_;
  size_t mark_count_ = 0;
};

}  // namespace psplit
