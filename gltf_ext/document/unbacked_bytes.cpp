#include "gltf_ext/document/unbacked_bytes.h"

#include "gltf_ext/document/element_layout.h"
#include "gltf_ext/document/extensions.h"
#include "gltf_ext/document/primitive_id.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

uint64_t bytes_of(const Json& json, const Json& index) {
  const Json* accessor = top_level_object(json, "accessors", integer_value(index).value_or(-1));
  if (accessor == nullptr || field(*accessor, "bufferView") != nullptr) return 0;
  const auto layout = element_layout(*accessor);
  const auto count = integer_field(*accessor, "count");
  return layout && count && *count > 0 ? static_cast<uint64_t>(*count) * layout->packed_bytes() : 0;
}

uint64_t unbacked_bytes(const Json& json, const Json& primitive) {
  const Json* extension = extension_field(primitive, kExtensionName);
  if (extension == nullptr) extension = extension_field(primitive, kStockExtensionName);
  const Json* stored = extension == nullptr ? nullptr : object_field(*extension, "attributes");
  uint64_t bytes = 0;
  if (const Json* attributes = object_field(primitive, "attributes"))
    for (const auto& [semantic, index] : attributes->items())
      if (stored == nullptr || !stored->contains(semantic)) bytes += bytes_of(json, index);
  const Json* indices = field(primitive, "indices");
  if (indices != nullptr && extension == nullptr) bytes += bytes_of(json, *indices);
  return bytes;
}

}  // namespace

Status check_unbacked_bytes(const Document& document) {
  uint64_t allowed = kFreeUnbackedBytes, claimed = 0;
  for (const auto& buffer : document.buffers) allowed += kUnbackedBytesOfAByte * buffer.size();
  for (const PrimitiveId id : all_primitives(document)) {
    claimed += unbacked_bytes(document.json, document.json["meshes"][id.mesh]["primitives"][id.primitive]);
    if (claimed > allowed)
      return invalid_input(
          "accessors without a buffer view claim " + std::to_string(claimed) +
              " bytes, but the bytes of the buffers justify " + std::to_string(allowed),
          {.mesh = static_cast<int64_t>(id.mesh), .primitive = static_cast<int64_t>(id.primitive)});
  }
  return {};
}

}  // namespace psplit
