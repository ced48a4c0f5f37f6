#include <optional>

#include "gltf_ext/document/read_steps.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

Status check_version(const Json& json) {
  const Json* asset = object_field(json, "asset");
  if (asset == nullptr) return invalid_input("the JSON has no asset object: not glTF 2.0");
  const std::string* version = string_field(*asset, "version");
  if (version == nullptr) return invalid_input("asset.version is missing or not a string");
  const std::string* least = string_field(*asset, "minVersion");
  if (least != nullptr && *least != "2.0")
    return unsupported("glTF " + *least + " is needed; 2.0 is supported");
  if (version->starts_with("2.")) return {};
  return unsupported("glTF version \"" + *version + "\"; 2.0 is supported");
}

Status check_arrays(const Json& json) {
  for (const char* name : {"accessors", "animations", "buffers", "bufferViews", "cameras", "images",
                           "materials", "meshes", "nodes", "samplers", "scenes", "skins", "textures"}) {
    const Json* array = field(json, name);
    if (array == nullptr) continue;
    if (!array->is_array()) return invalid_input(std::string(name) + " is not an array");
    for (size_t i = 0; i < array->size(); ++i)
      if (!(*array)[i].is_object())
        return invalid_input(std::string(name) + "[" + std::to_string(i) + "] is not an object");
  }
  for (const char* name : {"extensionsUsed", "extensionsRequired"}) {
    const Json* array = field(json, name);
    if (array == nullptr) continue;
    if (!array->is_array()) return invalid_input(std::string(name) + " is not an array");
    for (const Json& extension : *array)
      if (!extension.is_string())
        return invalid_input(std::string(name) + " has an element that is not a string");
  }
  return {};
}

// The place of an "extensions" that is not an object, as in ".meshes[0]", or nothing. The content of extensions
// and of extras is not checked.
std::optional<std::string> bad_extensions(const Json& tree) {
  if (!tree.is_structured()) return std::nullopt;
  const bool is_object = tree.is_object();
  size_t number = 0;
  for (auto member = tree.begin(); member != tree.end(); ++member, ++number) {
    if (is_object && member.key() == "extensions") {
      if (!member->is_object()) return "";
    } else if (!is_object || member.key() != "extras") {
      if (const auto place = bad_extensions(*member))
        return (is_object ? "." + member.key() : "[" + std::to_string(number) + "]") + *place;
    }
  }
  return std::nullopt;
}

}  // namespace

Status check_members(const Json& json) {
  if (Status status = check_version(json); !status.ok()) return status;
  if (Status status = check_arrays(json); !status.ok()) return status;
  const auto place = bad_extensions(json);
  if (!place) return {};
  return invalid_input((place->empty() ? "" : place->substr(1) + ": ") + "extensions is not an object");
}

}  // namespace psplit
