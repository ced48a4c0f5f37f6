#include "gltf_ext/convert/decode_document.h"

#include "gltf_ext/convert/validate.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/primitive/primitive_edit.h"

namespace psplit {

Status decode_document(Document& document, const DecodeBackend& backend, const ThreadPool& pool,
                       const Progress& progress) {
  std::vector<PrimitiveId> wanted;
  for (const PrimitiveId id : all_primitives(document)) {
    const Expected<PrimitiveKind> kind = primitive_kind(document, id);
    if (!kind) return kind.status().at({.file = document.source.string()});
    if (kind->storage != PrimitiveStorage::kPlain) {
      wanted.push_back(id);
    } else if (Status status = check_readable(document, id, backend, pool);
               status.code() == StatusCode::kInvalidInput) {
      return status;
    }
  }
  const std::vector<PrimitiveGroup> groups = group_equal_primitives(document, wanted);
  std::vector<PrimitiveId> ids;
  for (const PrimitiveGroup& group : groups) ids.push_back(group.ids.front());
  const std::vector<Expected<Mesh>> meshes = read_primitives(document, ids, backend, pool, progress);
  std::vector<PrimitiveId> patched;
  std::vector<const Mesh*> patched_meshes;
  for (size_t i = 0; i < ids.size(); ++i) {
    if (!meshes[i]) return meshes[i].status();
    if (extension_field(primitive_json(document, ids[i]), kExtensionName) == nullptr) {
      const auto morphs = read_morph_targets(document, ids[i], meshes[i]->point_count);
      if (morphs.status().code() == StatusCode::kInvalidInput) return morphs.status();
      continue;
    }
    patched.push_back(ids[i]);
    patched_meshes.push_back(&*meshes[i]);
  }
  if (Status status = check_decoded(document, patched, patched_meshes); !status.ok()) return status;

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
