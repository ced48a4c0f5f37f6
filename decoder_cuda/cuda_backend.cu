#include <memory>
#include <mutex>
#include <optional>

#include "decoder_cuda/cuda_kernels.cuh"
#include "decoder_cuda/host_decoder.h"
#include "psplit/cuda.h"

namespace psplit {

// Does nothing. A build that has it for a device has all kernels for it. Its name is the same in each
// compilation.
__global__ void probe_kernel() {}

bool cuda_available(std::string* why) {
  int device_count = 0;
  cudaError_t error = cudaGetDeviceCount(&device_count);
  // This build may have no code for the device.
  cudaFuncAttributes attributes;
  if (error == cudaSuccess && device_count > 0) error = cudaFuncGetAttributes(&attributes, probe_kernel);
  // The error also remains the runtime's last error. The next caller would take it for its own.
  if (error != cudaSuccess) (void)cudaGetLastError();
  const bool available = error == cudaSuccess && device_count > 0;
  if (why != nullptr) *why = available ? "" : error != cudaSuccess ? cudaGetErrorString(error) : "no device";
  return available;
}

uint32_t cuda_multiprocessors() {
  if (!cuda_available(nullptr)) return 0;
  int device = 0, count = 0;
  Status status = cuda_status(cudaGetDevice(&device), "cudaGetDevice");
  if (status.ok())
    status = cuda_status(cudaDeviceGetAttribute(&count, cudaDevAttrMultiProcessorCount, device),
                         "cudaDeviceGetAttribute");
  return status.ok() ? static_cast<uint32_t>(count) : 0;
}

std::string cuda_device_name() {
  if (!cuda_available(nullptr)) return "";
  int device = 0;
  cudaDeviceProp properties{};
  Status status = cuda_status(cudaGetDevice(&device), "cudaGetDevice");
  if (status.ok())
    status = cuda_status(cudaGetDeviceProperties(&properties, device), "cudaGetDeviceProperties");
  return status.ok() ? properties.name : "";
}

namespace {

// When a kernel is first launched, the driver takes memory for the stacks of all threads that can be resident.
Expected<uint64_t> local_memory(CudaDevice& device) {
  device.set_purpose(CudaDevice::Purpose::kMeasure);
  Status status = visit_kernels(device);
  device.set_purpose(CudaDevice::Purpose::kWork);
  int number = 0, threads = 0;
  if (status.ok()) status = cuda_status(cudaGetDevice(&number), "cudaGetDevice");
  if (status.ok())
    status = cuda_status(cudaDeviceGetAttribute(&threads, cudaDevAttrMaxThreadsPerMultiProcessor, number),
                         "cudaDeviceGetAttribute");
  if (!status.ok()) return status;
  return device.local_bytes() * static_cast<uint64_t>(threads) * device.multiprocessors();
}

}  // namespace

Expected<CudaDevice> create_device(cudaStream_t stream) {
  std::string why;
  if (!cuda_available(&why)) return unsupported("no CUDA device to decode on: " + why);
  Expected<CudaDevice> device = CudaDevice::create(stream);
  if (!device) return device;
  const Expected<uint64_t> bytes = local_memory(*device);
  if (!bytes) return bytes.status();
  device->set_local_memory(*bytes);
  return device;
}

Status cuda_warm_up() {
  Expected<CudaDevice> device = create_device(nullptr);
  if (!device) return device.status();
  device->set_purpose(CudaDevice::Purpose::kLoad);
  Status status = visit_kernels(*device);
  Status done = device->wait();
  return status.ok() ? done : status;
}

Expected<CudaMemory> CudaMemory::allocate(size_t bytes) {
  std::string why;
  if (!cuda_available(&why)) return unsupported("no CUDA device to decode on: " + why);
  void* data = nullptr;
  Status status = cuda_status(cudaMalloc(&data, bytes), "cudaMalloc", bytes);
  if (!status.ok()) return status;
  return CudaMemory(static_cast<std::byte*>(data), bytes);
}
CudaMemory::~CudaMemory() {
  if (data_ != nullptr) ignore(cudaFree(data_));
}
Status CudaMemory::download(const void* from, WritableBytes to) {
  Status status = cuda_status(cudaDeviceSynchronize(), "cudaDeviceSynchronize");
  if (!status.ok()) return status;
  return cuda_status(cudaMemcpy(to.data(), from, to.size(), cudaMemcpyDeviceToHost), "cudaMemcpy to the host");
}

struct PSPLIT_HIDDEN CudaDecoder::Implementation {
  BatchDecoder<CudaDevice> decoder;
  int device = 0;
};

CudaDecoder::CudaDecoder(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
CudaDecoder::CudaDecoder(CudaDecoder&&) noexcept = default;
CudaDecoder::~CudaDecoder() {
  if (implementation_ == nullptr) return;
  const CurrentDevice current(implementation_->device);
  implementation_.reset();
}

Expected<CudaDecoder> CudaDecoder::create(CUstream_st* stream) {
  Expected<CudaDevice> device = create_device(stream);
  if (!device) return device.status();
  int number = 0;
  Status status = cuda_status(cudaGetDevice(&number), "cudaGetDevice");
  if (!status.ok()) return status;
  return CudaDecoder(
      std::make_unique<Implementation>(Implementation{BatchDecoder<CudaDevice>(std::move(*device)), number}));
}

Status CudaDecoder::start(Span<const CudaPrimitive> primitives, const ThreadPool* pool) {
  const CurrentDevice current(implementation_->device);
  Status status = implementation_->decoder.start(primitives, pool);
  if (!status.ok()) (void)implementation_->decoder.device().take_times();
  return status;
}

Status CudaDecoder::finish() {
  const CurrentDevice current(implementation_->device);
  return implementation_->decoder.finish();
}

Status CudaDecoder::status(size_t primitive) const { return implementation_->decoder.status(primitive); }

uint32_t CudaDecoder::point_count(size_t primitive) const {
  return implementation_->decoder.point_count(primitive);
}

void CudaDecoder::set_memory_limit(uint64_t bytes) { implementation_->decoder.set_memory_limit(bytes); }

void CudaDecoder::measure(bool on) { implementation_->decoder.device().measure(on); }

std::vector<std::pair<std::string, double>> CudaDecoder::take_times() {
  const CurrentDevice current(implementation_->device);
  std::vector<std::pair<std::string, double>> times;
  for (const auto& [stage, ms] : implementation_->decoder.device().take_times()) {
    if (*stage == 0) continue;  // the time between batches
    const auto same =
        std::find_if(times.begin(), times.end(), [&](const auto& time) { return time.first == stage; });
    if (same == times.end())
      times.emplace_back(stage, ms);
    else
      same->second += ms;
  }
  return times;
}

DecodeBackend cuda_backend(uint64_t memory_limit) {
  struct Shared {
    std::mutex mutex;
    int device = 0;
    std::optional<HostDecoder<CudaDevice>> decoder;
    ~Shared() {
      const CurrentDevice current(device);
      decoder.reset();
    }
  };
  return {"cuda", [shared = std::make_shared<Shared>(), memory_limit](
                      std::span<const DecodeTask> tasks, const BuffersFor& buffers_for, const ThreadPool& pool,
                      const Watch& watch) {
            Shared& state = *shared;
            const std::lock_guard lock(state.mutex);
            if (!state.decoder) {
              Expected<CudaDevice> device = create_device(nullptr);
              if (!device) return std::vector<Status>(tasks.size(), device.status());
              ignore(cudaGetDevice(&state.device));  // create_device has asked it
              state.decoder.emplace(std::move(*device), memory_limit);
            }
            const CurrentDevice current(state.device);
            return state.decoder->decode_into(tasks, buffers_for, pool, watch);
          }};
}

}  // namespace psplit
