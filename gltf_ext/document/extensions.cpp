#include "gltf_ext/document/extensions.h"

#include <algorithm>
#include <set>

#include "gltf_ext/document/drop_unused.h"
#include "gltf_ext/json/extension_names.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

// The two Draco extensions stand together, stock Draco first, in the place of the one that was listed first.
// Condensing replaces one extension by the other in all primitives, and expanding replaces it back: so the list
// is then restored, although nothing says where the other one stood.
void join_draco_names(Json& names) {
  const auto stock = std::find(names.begin(), names.end(), Json(kStockExtensionName));
  const auto patches = std::find(names.begin(), names.end(), Json(kExtensionName));
  if (stock == names.end() || patches == names.end()) return;
  if (patches < stock)
    std::rotate(patches, stock, stock + 1);
  else
    std::rotate(stock + 1, patches, patches + 1);
}

void add_name(Json& json, const char* list, const char* name) {
  Json& names = json[list];
  if (!names.is_array()) names = Json::array();
  if (std::find(names.begin(), names.end(), Json(name)) == names.end()) names.push_back(name);
  join_draco_names(names);
}

bool remove_name(Json& json, const char* list, const std::string& name) {
  Json* names = array_field(json, list);
  if (names == nullptr) return false;
  const size_t before = names->size();
  for (size_t i = before; i > 0; --i)
    if ((*names)[i - 1] == name) names->erase(i - 1);
  const bool is_removed = names->size() < before;
  // glTF has no empty lists.
  if (names->empty()) json.erase(list);
  return is_removed;
}

// Adds every integer of the tree: each may be the index of an accessor or of a buffer view.
void collect_integers(const Json& tree, std::set<int64_t>& found) {
  if (const auto value = integer_value(tree)) found.insert(*value);
  if (tree.is_structured())
    for (const Json& member : tree) collect_integers(member, found);
}

// Returns the number of objects that had the extension. Its integers may be the indices of its accessors.
size_t remove_extension(Json& tree, const std::string& name, std::set<int64_t>& integers) {
  if (!tree.is_structured()) return 0;
  size_t count = 0;
  if (Json* extensions = object_field(tree, "extensions");
      extensions != nullptr && extensions->contains(name)) {
    collect_integers((*extensions)[name], integers);
    extensions->erase(name);
    if (extensions->empty()) tree.erase("extensions");
    ++count;
  }
  for (auto member = tree.begin(); member != tree.end(); ++member)
    if (!tree.is_object() || member.key() != "extras") count += remove_extension(*member, name, integers);
  return count;
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

bool lists_extension(const Json& json, const char* list, const char* name) {
  const Json* names = array_field(json, list);
  return names != nullptr && std::find(names->begin(), names->end(), name) != names->end();
}

void list_extension(Document& document, const char* name, bool required) {
  add_name(document.json(), "extensionsUsed", name);
  if (required) add_name(document.json(), "extensionsRequired", name);
}

void join_draco_extensions(Document& document) {
  for (const char* list : {"extensionsUsed", "extensionsRequired"})
    if (Json* names = array_field(document.json(), list)) join_draco_names(*names);
}

void require_extension(Document& document, const char* name, bool required) {
  if (!lists_extension(document.json(), "extensionsUsed", name)) return;
  if (required)
    add_name(document.json(), "extensionsRequired", name);
  else
    remove_name(document.json(), "extensionsRequired", name);
}

std::optional<size_t> drop_extension(Document& document, const std::string& name) {
  std::set<int64_t> integers;
  const size_t count = remove_extension(document.json(), name, integers);
  const bool was_used = remove_name(document.json(), "extensionsUsed", name);
  const bool was_required = remove_name(document.json(), "extensionsRequired", name);
  if (count == 0) return was_used || was_required ? std::optional(count) : std::nullopt;
  // Candidates, of which only accessors that nothing refers to go.
  if (!integers.empty()) drop_unused(document, {integers.begin(), integers.end()});
  return count;
}

void unlist_unused_extension(Document& document, const char* name) {
  if (!lists_extension(document.json(), "extensionsUsed", name) &&
      !lists_extension(document.json(), "extensionsRequired", name))
    return;
  if (contains_extension(document.json(), name)) return;
  remove_name(document.json(), "extensionsUsed", name);
  remove_name(document.json(), "extensionsRequired", name);
}

}  // namespace psplit
