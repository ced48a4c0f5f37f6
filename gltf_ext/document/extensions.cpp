#include "gltf_ext/document/extensions.h"

#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

void add_name(Json& json, const char* list, const char* name) {
  Json& names = json[list];
  if (!names.is_array()) names = Json::array();
  if (std::find(names.begin(), names.end(), Json(name)) == names.end()) names.push_back(name);
}

void remove_name(Json& json, const char* list, const char* name) {
  Json* names = array_field(json, list);
  if (names == nullptr) return;
  for (size_t i = names->size(); i > 0; --i)
    if ((*names)[i - 1] == name) names->erase(i - 1);
  // glTF has no empty lists.
  if (names->empty()) json.erase(list);
}

bool contains_extension(const Json& tree, const char* name) {
  if (!tree.is_structured()) return false;
  if (const Json* extensions = object_field(tree, "extensions");
      extensions != nullptr && extensions->contains(name))
    return true;
  return std::any_of(tree.begin(), tree.end(),
                     [&](const Json& member) { return contains_extension(member, name); });
}

}  // namespace

void list_extension(Document& document, const char* name, bool required) {
  add_name(document.json, "extensionsUsed", name);
  if (required) add_name(document.json, "extensionsRequired", name);
}

void unlist_unused_extension(Document& document, const char* name) {
  if (contains_extension(document.json, name)) return;
  remove_name(document.json, "extensionsUsed", name);
  remove_name(document.json, "extensionsRequired", name);
}

}  // namespace psplit
