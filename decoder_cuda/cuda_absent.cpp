// Stands in for the CUDA decoder where the build has no CUDA toolkit, so that callers need no #ifdef.
#include "decoder_cuda/psplit_cuda.h"

namespace psplit {

bool cuda_available(std::string* why) {
  if (why != nullptr) *why = "built without CUDA";
  return false;
}

DecodeBackend cuda_backend() {
  const auto absent = [] { return unsupported("no CUDA device to decode on: built without CUDA"); };
  return {
      "cuda",
      [=](std::span<const uint8_t>, std::span<const AttributeRequest>, const ThreadPool&) -> Expected<Mesh> {
        return absent();
      },
      [=](std::span<const uint8_t>, std::span<const AttributeRequest>) -> Expected<Mesh> { return absent(); }};
}

}  // namespace psplit
