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

bool cuda_available(std::string* why) {
  int device_count = 0;
  const cudaError_t error = cudaGetDeviceCount(&device_count);
  // The error also stays behind as the runtime's last one, where the next caller would take it for its own.
  if (error != cudaSuccess) (void)cudaGetLastError();
  const bool available = error == cudaSuccess && device_count > 0;
  if (why != nullptr) *why = available ? "" : error != cudaSuccess ? cudaGetErrorString(error) : "no device";
  return available;
}

namespace {

// One decoder for all: the device is one, and its memory is kept.
struct SharedDecoder {
  std::mutex mutex;
  std::optional<BatchDecoder<CudaDevice>> decoder;
};

Expected<Mesh> decode_container(std::span<const uint8_t> container,
                                std::span<const AttributeRequest> requests) {
  static SharedDecoder& shared = *new SharedDecoder;  // the driver is gone when statics are destroyed
  const std::lock_guard lock(shared.mutex);
  if (!shared.decoder) {
    std::string why;
    if (!cuda_available(&why)) return unsupported("no CUDA device to decode on: " + why);
    Expected<CudaDevice> device = CudaDevice::create();
    if (!device) return device.status();
    shared.decoder.emplace(std::move(*device));
  }
  return decode_to_host(*shared.decoder, container, requests);
}

}  // namespace

DecodeBackend cuda_backend() {
  return {"cuda",
          [](std::span<const uint8_t> container, std::span<const AttributeRequest> requests,
             const ThreadPool&) { return decode_container(container, requests); },
          [](std::span<const uint8_t>, std::span<const AttributeRequest>) -> Expected<Mesh> {
            return unsupported("the CUDA decoder takes patches only, not whole Draco streams");
          }};
}

}  // namespace psplit
