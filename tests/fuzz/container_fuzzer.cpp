// Any bytes as a container, decoded with one attribute and stitched.
#include "src/cpu/cpu_backend.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const psplit::ThreadPool pool(1);
  static const std::vector<psplit::AttributeRequest> requests{{.semantic = "POSITION"}};
  (void)psplit::cpu_backend().decode_container({data, size}, requests, pool);
  return 0;
}
