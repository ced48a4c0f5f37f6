#include "gltf_ext/document/primitive_id.h"

#include "gltf_ext/json/json_fields.h"

namespace psplit {

std::vector<PrimitiveId> all_primitives(const Document& document) {
  std::vector<PrimitiveId> ids;
  const Json* meshes = array_field(document.json, "meshes");
  for (size_t m = 0; meshes != nullptr && m < meshes->size(); ++m)
    for (size_t p = 0; p < array_size((*meshes)[m], "primitives"); ++p) ids.push_back({m, p});
  return ids;
}

}  // namespace psplit
