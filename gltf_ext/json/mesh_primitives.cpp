#include "gltf_ext/json/mesh_primitives.h"

#include <algorithm>
#include <utility>

namespace psplit {
namespace {

bool is_list_of_objects(const Json* list) {
  return list != nullptr && !list->empty() &&
         std::all_of(list->begin(), list->end(), [](const Json& primitive) { return primitive.is_object(); });
}

}  // namespace

Status exchange_primitives(Json& json) {
  Json* meshes = array_field(json, "meshes");
  for (size_t i = 0; meshes != nullptr && i < meshes->size(); ++i) {
    Json& mesh = (*meshes)[i];
    Json* extensions = object_field(mesh, "extensions");
    if (extensions == nullptr || field(*extensions, kExtensionName) == nullptr) continue;
    const Place place{.mesh = static_cast<int64_t>(i)};
    Json* const first = array_field(mesh, "primitives");
    Json* const other = other_primitives(mesh);
    if (!is_list_of_objects(other))
      return invalid_input(std::string(kExtensionName) + " of a mesh has no list of primitives", place);
    if (!is_list_of_objects(first)) return invalid_input("no list of primitives", place);
    std::swap(*first, *other);
  }
  return {};
}

}  // namespace psplit
