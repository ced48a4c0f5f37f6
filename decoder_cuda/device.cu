#include <cuda_runtime_api.h>

#include "decoder_cuda/psplit_cuda.h"

namespace psplit {

bool cuda_available(std::string* why) {
  int device_count = 0;
  const cudaError_t error = cudaGetDeviceCount(&device_count);
  // The error also stays behind as the runtime's last one, where the next caller would take it for its own.
  if (error != cudaSuccess) (void)cudaGetLastError();
  const bool available = error == cudaSuccess && device_count > 0;
  if (why != nullptr) *why = available ? "" : error != cudaSuccess ? cudaGetErrorString(error) : "no device";
  return available;
}

}  // namespace psplit
