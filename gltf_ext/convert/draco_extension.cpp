#include "gltf_ext/convert/draco_extension.h"

#include "gltf_ext/json/json_fields.h"

namespace psplit {

std::vector<AttributeRequest> requests_of(const Mesh& mesh, const std::vector<uint32_t>& unique_ids) {
  std::vector<AttributeRequest> requests;
  for (size_t i = 0; i < mesh.attributes.size(); ++i) {
    const Attribute& a = mesh.attributes[i];
    requests.push_back({a.semantic, unique_ids[i], a.component_type, a.component_count, a.normalized});
  }
  return requests;
}

void set_draco_extension(Document& document, const PrimitiveGroup& group, const char* name, int64_t buffer_view,
                         const Mesh& mesh, const std::vector<uint32_t>& unique_ids) {
  Json attributes = Json::object();
  for (size_t i = 0; i < mesh.attributes.size(); ++i) attributes[mesh.attributes[i].semantic] = unique_ids[i];
  const Json extension{{"bufferView", buffer_view}, {"attributes", attributes}};
  for (const PrimitiveId id : group.ids) {
    Json& primitive = primitive_json(document, id);
    if (Json* extensions = object_field(primitive, "extensions"))
      for (const char* other : {kExtensionName, kStockExtensionName}) extensions->erase(other);
    primitive["extensions"][name] = extension;
  }
}

}  // namespace psplit
