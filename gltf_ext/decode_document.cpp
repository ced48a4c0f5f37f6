#include "gltf_ext/convert.h"
#include "gltf_ext/json_fields.h"
#include "gltf_ext/primitive_edit.h"

namespace psplit {

Status decode_document(Document& document, const DecodeBackend& backend, const ThreadPool& pool,
                       const Progress& progress) {
  std::vector<PrimitiveId> wanted;
  for (const PrimitiveId id : all_primitives(document)) {
    const Expected<PrimitiveKind> kind = primitive_kind(document, id);
    if (!kind) return kind.status().at({.file = document.source.string()});
    if (kind->storage != PrimitiveStorage::kPlain) wanted.push_back(id);
  }
  const std::vector<PrimitiveGroup> groups = group_equal_primitives(document, wanted);
  std::vector<PrimitiveId> ids;
  for (const PrimitiveGroup& group : groups) ids.push_back(group.ids.front());
  const std::vector<Expected<Mesh>> meshes = read_primitives(document, ids, backend, pool, progress);
  for (const Expected<Mesh>& mesh : meshes)
    if (!mesh) return mesh.status();

  PrimitiveEditor editor(document);
  for (size_t i = 0; i < groups.size(); ++i) {
    Json& first = primitive_json(document, groups[i].ids.front());
    std::vector<std::string> decoded;
    for (const char* name : {kExtensionName, kStockExtensionName})
      if (const Json* extension = extension_field(first, name))
        for (const auto& [semantic, id] : (*extension)["attributes"].items()) decoded.push_back(semantic);
    editor.set_geometry(groups[i], *meshes[i], {}, GeometryData::kInBufferViews, decoded);
    for (const PrimitiveId id : groups[i].ids) {
      Json& primitive = primitive_json(document, id);
      Json& extensions = primitive["extensions"];
      for (const char* name : {kExtensionName, kStockExtensionName}) extensions.erase(name);
      if (extensions.empty()) primitive.erase("extensions");
    }
  }
  editor.finish();
  return {};
}

}  // namespace psplit
