#include "gltf_ext/convert/draco_extension.h"

#include "gltf_ext/json/json_fields.h"

namespace psplit {

void set_draco_extension(Document& document, const PrimitiveGroup& group, const char* name, int64_t buffer_view,
                         std::span<const AttributeRequest> requests) {
  Json attributes = Json::object();
  for (const AttributeRequest& request : requests) attributes[request.semantic] = request.unique_id;
  const Json extension{{"bufferView", buffer_view}, {"attributes", attributes}};
  for (const PrimitiveId id : group.ids) {
    Json& primitive = primitive_json(document, id);
    if (Json* extensions = object_field(primitive, "extensions"))
      for (const char* other : {kExtensionName, kStockExtensionName}) extensions->erase(other);
    primitive["extensions"][name] = extension;
  }
}

}  // namespace psplit
