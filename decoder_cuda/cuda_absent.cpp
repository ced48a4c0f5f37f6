// Stands in for the CUDA decoder where the build has no CUDA toolkit, so that callers need no #ifdef.
#include "decoder_cuda/psplit_cuda.h"

namespace psplit {

bool cuda_available(std::string* why) {
  if (why != nullptr) *why = "built without CUDA";
  return false;
}

}  // namespace psplit
