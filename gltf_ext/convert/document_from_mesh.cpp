#include "gltf_ext/primitive/primitive_edit.h"
#include "psplit/document.h"

namespace psplit {

Document document_from_mesh(const Mesh& mesh) {
  Document document = new_document();
  Json attributes = Json::object();
  for (const Attribute& attribute : mesh.attributes) {
    const AccessorData data{attribute.component_type, attribute.component_count, attribute.normalized,
                            mesh.point_count, attribute.values};
    attributes[attribute.semantic] =
        append_accessor(document, data, kArrayBuffer, attribute.semantic == "POSITION");
  }
  const Json primitive = {{"attributes", attributes}};
  document.json()["meshes"] = Json::array({Json{{"primitives", Json::array({primitive})}}});
  PrimitiveEditor(document).set_geometry({{{0, 0}}}, mesh, {}, GeometryData::kInBufferViews, {"indices only"});
  return document;
}

}  // namespace psplit
