// Feeds any bytes to the core's decoder of point clouds, and to the reader of metadata. No index may be out of
// bounds, and no loop may be endless.
#include <memory>
#include <vector>

#include "psplit/decode.h"
#include "src/core/decode_cloud.h"

namespace {

template <typename Index>
void decode(const psplit::core::CloudHeader& header) {
  static std::vector<uint8_t> memory(size_t{1} << 22);
  static const auto patch = std::make_unique<psplit::core::Patch<Index>>();
  psplit::core::Arena arena(memory.data(), memory.size());
  *patch = {};
  if (psplit::core::decode_cloud<Index>(header, arena, *patch) != psplit::core::Fault::kNone) return;
  std::vector<uint8_t> value;
  for (uint32_t i = 0; i < patch->attributes.size(); ++i) {
    value.resize(patch->attributes[i].stride());
    patch->write_values(patch->attributes[i], [&](uint32_t) { return value.data(); });
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  (void)psplit::read_metadata({data, size});
  psplit::core::CloudHeader header;
  if (psplit::core::read_cloud_header(data, size, header) != psplit::core::Fault::kNone) return 0;
  decode<uint32_t>(header);
  if (header.fits_16_bits()) decode<uint16_t>(header);
  return 0;
}
