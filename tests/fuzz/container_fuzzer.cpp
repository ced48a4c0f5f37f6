// Decodes any bytes as a container with one attribute, and stitches the result.
#include "psplit/decode.h"
#include "tests/support/decode_bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const psplit::ThreadPool pool(1);
  static const std::vector<psplit::AttributeRequest> requests{{.semantic = "POSITION"}};
  (void)psplit::decode_container(psplit::cpu_backend(), {data, size}, requests, pool);
  return 0;
}
