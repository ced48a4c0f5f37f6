#include <memory>
#include <mutex>
#include <optional>

#include "decoder_cuda/batch_decoder.h"
#include "decoder_cuda/cuda_device.cuh"
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

struct CudaDecoder::Implementation {
  BatchDecoder<CudaDevice> decoder;
};

CudaDecoder::CudaDecoder(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
CudaDecoder::CudaDecoder(CudaDecoder&&) noexcept = default;
CudaDecoder::~CudaDecoder() = default;

namespace {

Expected<BatchDecoder<CudaDevice>> create_decoder(cudaStream_t stream) {
  std::string why;
  if (!cuda_available(&why)) return unsupported("no CUDA device to decode on: " + why);
  Expected<CudaDevice> device = CudaDevice::create(stream);
  if (!device) return device.status();
  return BatchDecoder<CudaDevice>(std::move(*device));
}

}  // namespace

Expected<CudaDecoder> CudaDecoder::create(CUstream_st* stream) {
  Expected<BatchDecoder<CudaDevice>> decoder = create_decoder(stream);
  if (!decoder) return decoder.status();
  return CudaDecoder(std::make_unique<Implementation>(Implementation{std::move(*decoder)}));
}

Status CudaDecoder::start(std::span<const CudaPrimitive> primitives) {
  std::vector<Container> containers;
  containers.reserve(primitives.size());
  std::vector<BatchPrimitive> batch;
  for (const CudaPrimitive& primitive : primitives) {
    Expected<Container> container = primitive.stream_points > 0
                                        ? container_of_stream(primitive.container, primitive.stream_points)
                                        : parse_container(primitive.container);
    if (!container) return container.status();
    containers.push_back(std::move(*container));
    batch.push_back({.bytes = primitive.container,
                     .container = &containers.back(),
                     .targets = {},
                     .indices = primitive.indices,
                     .index_bytes = primitive.index_bytes,
                     .is_stitched = primitive.is_stitched,
                     .first = primitive.first,
                     .end = primitive.end,
                     .bounds = primitive.bounds});
    for (const CudaAttribute& attribute : primitive.attributes)
      batch.back().targets.push_back({.unique_id = attribute.unique_id,
                                      .type = stored_type(attribute.component_type),
                                      .components = attribute.component_count,
                                      .values = static_cast<uint8_t*>(attribute.values),
                                      .stride = attribute.stride,
                                      .grid = attribute.grid});
  }
  return implementation_->decoder.start(batch);
}

Status CudaDecoder::finish() { return implementation_->decoder.finish(); }

void CudaDecoder::set_workspace_limit(uint64_t bytes) { implementation_->decoder.set_workspace_limit(bytes); }

void CudaDecoder::measure(bool on) { implementation_->decoder.device().measure(on); }

std::vector<std::pair<std::string, double>> CudaDecoder::take_times() {
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

DecodeBackend cuda_backend() {
  return {"cuda",
          [](std::span<const uint8_t> container, std::span<const AttributeRequest> requests,
             const ThreadPool&) -> Expected<Mesh> {
            // One decoder for all. The driver is gone when statics are destroyed.
            static std::mutex& mutex = *new std::mutex;
            static std::optional<BatchDecoder<CudaDevice>>& decoder =
                *new std::optional<BatchDecoder<CudaDevice>>;
            const std::lock_guard lock(mutex);
            if (!decoder) {
              Expected<BatchDecoder<CudaDevice>> created = create_decoder(nullptr);
              if (!created) return created.status();
              decoder.emplace(std::move(*created));
            }
            return decode_to_host(*decoder, container, requests);
          },
          [](std::span<const uint8_t>, std::span<const AttributeRequest>) -> Expected<Mesh> {
            return unsupported("the CUDA decoder takes patches only, not whole Draco streams");
          }};
}

}  // namespace psplit
