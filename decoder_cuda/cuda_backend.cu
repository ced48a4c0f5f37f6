#include <memory>
#include <mutex>
#include <optional>

#include "decoder_cuda/cuda_device.cuh"
#include "decoder_cuda/host_decoder.h"
#include "decoder_cuda/psplit_cuda.h"

namespace psplit {

extern template Status launch_decoding<uint16_t>(CudaDevice&, const StreamSet<uint16_t>&, const LaunchPlan&);
extern template Status launch_decoding<uint32_t>(CudaDevice&, const StreamSet<uint32_t>&, const LaunchPlan&);
extern template Status launch_writing<uint16_t>(CudaDevice&, const StreamSet<uint16_t>&);
extern template Status launch_writing<uint32_t>(CudaDevice&, const StreamSet<uint32_t>&);

namespace {

__global__ void probe() {}

}  // namespace

bool cuda_available(std::string* why) {
  int device_count = 0;
  cudaError_t error = cudaGetDeviceCount(&device_count);
  // There may be no code for it in this build.
  cudaFuncAttributes attributes;
  if (error == cudaSuccess && device_count > 0) error = cudaFuncGetAttributes(&attributes, probe);
  // The error also stays behind as the runtime's last one, where the next caller would take it for its own.
  if (error != cudaSuccess) (void)cudaGetLastError();
  const bool available = error == cudaSuccess && device_count > 0;
  if (why != nullptr) *why = available ? "" : error != cudaSuccess ? cudaGetErrorString(error) : "no device";
  return available;
}

uint32_t cuda_multiprocessors() {
  if (!cuda_available(nullptr)) return 0;
  int device = 0, count = 0;
  Status status = cuda_status(cudaGetDevice(&device), "no device");
  if (status.ok())
    status = cuda_status(cudaDeviceGetAttribute(&count, cudaDevAttrMultiProcessorCount, device), "no device");
  return status.ok() ? static_cast<uint32_t>(count) : 0;
}

std::string cuda_device_name() {
  if (!cuda_available(nullptr)) return "";
  int device = 0;
  cudaDeviceProp properties{};
  Status status = cuda_status(cudaGetDevice(&device), "no device");
  if (status.ok()) status = cuda_status(cudaGetDeviceProperties(&properties, device), "no device");
  return status.ok() ? properties.name : "";
}

namespace {

// Makes a device current for a while.
class CurrentDevice {
 public:
  explicit CurrentDevice(int device) {
    (void)cudaGetDevice(&before_);
    if (before_ != device) (void)cudaSetDevice(device);
    device_ = device;
  }
  ~CurrentDevice() {
    if (before_ != device_) (void)cudaSetDevice(before_);
  }
  CurrentDevice(const CurrentDevice&) = delete;
  CurrentDevice& operator=(const CurrentDevice&) = delete;

 private:
  int before_ = 0, device_ = 0;
};

Expected<CudaDevice> create_device(cudaStream_t stream) {
  std::string why;
  if (!cuda_available(&why)) return unsupported("no CUDA device to decode on: " + why);
  return CudaDevice::create(stream);
}

}  // namespace

Expected<CudaMemory> CudaMemory::allocate(size_t bytes) {
  std::string why;
  if (!cuda_available(&why)) return unsupported("no CUDA device to decode on: " + why);
  void* data = nullptr;
  Status status = cuda_status(cudaMalloc(&data, bytes), "cannot allocate memory");
  if (!status.ok()) return status;
  return CudaMemory(static_cast<std::byte*>(data), bytes);
}
CudaMemory::~CudaMemory() { (void)cudaFree(data_); }
Status CudaMemory::download(const void* from, std::span<std::byte> to) {
  Status status = cuda_status(cudaDeviceSynchronize(), "decoding");
  if (!status.ok()) return status;
  return cuda_status(cudaMemcpy(to.data(), from, to.size(), cudaMemcpyDeviceToHost), "download");
}

struct PSPLIT_HIDDEN CudaDecoder::Implementation {
  BatchDecoder<CudaDevice> decoder;
  int device = 0;
  CudaDevice::HostArray<uint8_t> pinned_bytes{};  // of containers on the device
  std::vector<uint8_t> pageable_bytes{};          // of those that are too large to pin
  std::vector<Expected<Container>> containers{};
  std::vector<std::vector<core::StreamHeader>> headers{};
  std::vector<size_t> batch_places{};  // of each primitive; kRefused of those whose containers are broken
  std::vector<Status> refusals{};

  static constexpr size_t kRefused = ~size_t{0};

  Status start(std::span<const CudaPrimitive> primitives);
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
  Status status = cuda_status(cudaGetDevice(&number), "no device");
  if (!status.ok()) return status;
  return CudaDecoder(
      std::make_unique<Implementation>(Implementation{BatchDecoder<CudaDevice>(std::move(*device)), number}));
}

Status CudaDecoder::Implementation::start(std::span<const CudaPrimitive> primitives) {
  CudaDevice& on = decoder.device();
  // Containers on the device are planned by a copy.
  size_t size = 0;
  for (const CudaPrimitive& primitive : primitives)
    if (primitive.is_on_device) size += primitive.container.size();
  constexpr size_t kMostPinned = size_t{64} << 20;
  pageable_bytes.resize(size > kMostPinned ? size : 0);
  if (pageable_bytes.empty())
    if (Status status = grow(pinned_bytes, size); !status.ok()) return status;
  uint8_t* next_copy = pageable_bytes.empty() ? pinned_bytes.data() : pageable_bytes.data();
  std::vector<std::span<const uint8_t>> bytes;
  for (const CudaPrimitive& primitive : primitives) {
    bytes.push_back(primitive.container);
    if (!primitive.is_on_device) continue;
    uint8_t* const copy = std::exchange(next_copy, next_copy + primitive.container.size());
    Status status = on.download(copy, primitive.container.data(), primitive.container.size());
    if (!status.ok()) return status;
    bytes.back() = {copy, primitive.container.size()};
  }
  if (size > 0)
    if (Status status = on.wait(); !status.ok()) return status;

  const size_t count = primitives.size();
  containers.clear();
  headers.assign(count, {});
  batch_places.assign(count, kRefused);
  refusals.assign(count, Status());
  std::vector<BatchPrimitive> batch;
  for (size_t i = 0; i < count; ++i)
    containers.push_back(primitives[i].stream_points > 0
                             ? container_of_stream(bytes[i], primitives[i].stream_points)
                             : parse_container(bytes[i]));
  for (size_t i = 0; i < count; ++i) {
    const CudaPrimitive& primitive = primitives[i];
    Status status = containers[i].status();
    if (status.ok()) {
      Expected<std::vector<core::StreamHeader>> checked = check_claims(*containers[i]);
      status = checked.status();
      if (checked) headers[i] = std::move(*checked);
    }
    if (!status.ok()) {
      refusals[i] = std::move(status).at({.primitive = static_cast<int64_t>(i)});
      continue;
    }
    batch_places[i] = batch.size();
    BatchPrimitive& planned = batch.emplace_back();
    planned.bytes = bytes[i];
    planned.device_bytes = primitive.is_on_device ? primitive.container.data() : nullptr;
    planned.container = &*containers[i];
    planned.headers = &headers[i];
    planned.is_stream = primitive.stream_points > 0;
    planned.indices = primitive.indices;
    planned.index_bytes = primitive.index_bytes;
    planned.is_stitched = primitive.is_stitched;
    planned.first = primitive.first;
    planned.end = primitive.end;
    planned.bounds = primitive.bounds;
    for (const CudaAttribute& attribute : primitive.attributes)
      planned.targets.push_back({.unique_id = attribute.unique_id,
                                 .type = stored_type(attribute.component_type),
                                 .components = attribute.component_count,
                                 .values = static_cast<uint8_t*>(attribute.values),
                                 .stride = attribute.stride,
                                 .grid = attribute.grid});
  }
  return decoder.start(batch);
}

Status CudaDecoder::start(std::span<const CudaPrimitive> primitives) {
  const CurrentDevice current(implementation_->device);
  Status status = implementation_->start(primitives);
  if (!status.ok()) {
    (void)implementation_->decoder.device().wait();
    (void)implementation_->decoder.device().take_times();
    implementation_->refusals.assign(primitives.size(), status);
    implementation_->batch_places.assign(primitives.size(), Implementation::kRefused);
  }
  return status;
}

Status CudaDecoder::finish() {
  const CurrentDevice current(implementation_->device);
  (void)implementation_->decoder.finish();
  for (size_t i = 0; i < implementation_->refusals.size(); ++i)
    if (Status each = status(i); !each.ok()) return each;
  return {};
}

Status CudaDecoder::status(size_t primitive) const {
  const size_t place = implementation_->batch_places[primitive];
  if (place == Implementation::kRefused) return implementation_->refusals[primitive];
  const Status& status = implementation_->decoder.status(place);
  return Status(status.code(), status.message(),
                {.primitive = static_cast<int64_t>(primitive), .patch = status.place().patch});
}

uint32_t CudaDecoder::point_count(size_t primitive) const {
  const size_t place = implementation_->batch_places[primitive];
  return place == Implementation::kRefused ? 0 : implementation_->decoder.point_count(place);
}

void CudaDecoder::set_memory_limit(uint64_t bytes) { implementation_->decoder.set_memory_limit(bytes); }

void CudaDecoder::measure(bool on) { implementation_->decoder.device().measure(on); }

std::vector<std::pair<std::string, double>> CudaDecoder::take_times() {
  const CurrentDevice current(implementation_->device);
  std::vector<std::pair<std::string, double>> times;
  for (const auto& [stage, ms] : implementation_->decoder.device().take_times()) {
    if (*stage == 0) continue;  // between batches
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
                      std::span<const DecodeTask> tasks, const ThreadPool&, const Progress& progress) {
            Shared& state = *shared;
            const std::lock_guard lock(state.mutex);
            if (!state.decoder) {
              Expected<CudaDevice> device = create_device(nullptr);
              if (!device) return std::vector<Expected<Mesh>>(tasks.size(), device.status());
              (void)cudaGetDevice(&state.device);
              state.decoder.emplace(std::move(*device), memory_limit);
            }
            const CurrentDevice current(state.device);
            return state.decoder->decode(tasks, progress);
          }};
}

}  // namespace psplit
