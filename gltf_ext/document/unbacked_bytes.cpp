#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/read_steps.h"

namespace psplit {
namespace {

uint64_t unbacked_bytes(const AssetRecords& records, const PrimitiveRecord& primitive) {
  const auto bytes_of = [&](int64_t index) {
    const AccessorRecord* accessor = index < 0 ? nullptr : &records.accessor(index);
    return accessor == nullptr || accessor->has_view() ? 0 : accessor->packed_bytes();
  };
  const DracoRecord* draco = primitive.draco();
  uint64_t bytes = draco == nullptr ? bytes_of(primitive.indices) : 0;
  for (const auto& [semantic, accessor] : primitive.attributes)
    if (draco == nullptr || !draco->stores(semantic)) bytes += bytes_of(accessor);
  return bytes;
}

}  // namespace

Status check_unbacked_bytes(const Document& document) {
  uint64_t allowed = kFreeUnbackedBytes, claimed = 0;
  for (const auto& buffer : document.buffers) allowed += kUnbackedBytesOfAByte * buffer.size();
  for (const PrimitiveId id : all_primitives(document)) {
    claimed += unbacked_bytes(document.records(), document.records().primitive(id));
    if (claimed > allowed)
      return invalid_input("accessors without a buffer view claim " + std::to_string(claimed) +
                               " bytes, but the bytes of the buffers justify " + std::to_string(allowed),
                           place_of(id));
  }
  return {};
}

}  // namespace psplit
