#include "gltf_ext/convert/stated_bytes.h"

#include <vector>

#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/primitive/mesh_view.h"
#include "gltf_ext/primitive/primitive_edit.h"
#include "gltf_ext/primitive/read_primitives.h"
#include "src/container/claims.h"

namespace psplit {
namespace {

uint64_t count_of(const Document& document, const Json* index) {
  const auto number = index == nullptr ? std::nullopt : integer_value(*index);
  const Json* accessor = number ? top_level_object(document.json, "accessors", *number) : nullptr;
  const auto count = accessor == nullptr ? std::nullopt : integer_field(*accessor, "count");
  return count && *count > 0 ? static_cast<uint64_t>(*count) : 0;
}

bool is_compressed(const Document& document, PrimitiveId id) {
  const Expected<PrimitiveKind> kind = primitive_kind(document, id);
  return kind && kind->storage != PrimitiveStorage::kPlain;
}

}  // namespace

StatedBytes stated_bytes(const Document& document, PrimitiveId id) {
  if (!is_compressed(document, id)) return {};
  const bool in_patches = primitive_kind(document, id)->storage == PrimitiveStorage::kPatches;
  const auto stored = stored_primitive(document, id, in_patches ? kExtensionName : kStockExtensionName);
  if (!stored) return {};
  const Json& primitive = document.json["meshes"][id.mesh]["primitives"][id.primitive];
  const Json* attributes = object_field(primitive, "attributes");
  const uint64_t points = attributes == nullptr ? 0 : count_of(document, field(*attributes, "POSITION"));
  const uint64_t faces = count_of(document, field(primitive, "indices")) / 3;
  if (points > UINT32_MAX || faces > UINT32_MAX / 3 ||
      !check_results(points, faces, stored->requests, stored->bytes.size()).ok())
    return {};
  const LaidOutMesh mesh =
      lay_out(stored->requests, static_cast<uint32_t>(points), static_cast<uint32_t>(faces), 0, {});
  return {stored->bytes.size(), mesh.end};
}

StatedBytes stated_bytes(const Document& document) {
  std::vector<PrimitiveId> compressed;
  for (const PrimitiveId id : all_primitives(document))
    if (is_compressed(document, id)) compressed.push_back(id);
  StatedBytes sum;
  for (const PrimitiveGroup& group : group_equal_primitives(document, compressed)) {
    const StatedBytes bytes = stated_bytes(document, group.ids.front());
    sum.stored += bytes.stored;
    sum.decoded += bytes.decoded;
  }
  return sum;
}

}  // namespace psplit
