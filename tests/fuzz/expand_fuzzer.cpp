// Opens any bytes as a container of condensed streams with one attribute, and expands its condensed streams.
// What can be expanded must decode to the same mesh in both forms.
#include "encoder/fields/expand_container.h"
#include "psplit/decode.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const psplit::ThreadPool pool(1);
  static const psplit::DecodeBackend backend = psplit::cpu_backend();
  static const std::vector<psplit::AttributeRequest> requests{{.semantic = "POSITION"}};
  const auto container = psplit::open_container({data, size});
  if (!container || container->condensed_count() == 0) return 0;
  const auto expanded = psplit::expand_container(*container, pool);
  if (!expanded) return 0;
  const auto opened = psplit::open_container(*expanded);
  if (!opened) return 0;
  const auto expected = backend.decode(*opened, requests, pool);
  if (!expected) return 0;
  const auto decoded = backend.decode(*container, requests, pool);
  if (!decoded || decoded->faces != expected->faces ||
      decoded->attributes[0].values != expected->attributes[0].values)
    __builtin_trap();
  return 0;
}
