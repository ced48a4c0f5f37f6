#include <atomic>

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
  std::vector<Mesh> meshes(groups.size());
  std::vector<Status> statuses(groups.size());
  std::atomic<size_t> done = 0;
  pool.for_each(groups.size(), [&](size_t i) {
    Expected<Mesh> mesh = read_primitive(document, groups[i].ids.front(), backend, pool);
    if (mesh.ok())
      meshes[i] = std::move(*mesh);
    else
      statuses[i] = mesh.status();
    if (progress) progress(++done, groups.size());
  });
  for (Status& status : statuses)
    if (!status.ok()) return std::move(status);

  PrimitiveEditor editor(document);
  for (size_t i = 0; i < groups.size(); ++i) {
    Json& first = primitive_json(document, groups[i].ids.front());
    std::vector<std::string> decoded;
    for (const char* name : {kExtensionName, kStockExtensionName})
      if (const Json* extension = extension_field(first, name))
        for (const auto& [semantic, id] : (*extension)["attributes"].items()) decoded.push_back(semantic);
    editor.set_geometry(groups[i], meshes[i], {}, GeometryData::kInBufferViews, decoded);
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
