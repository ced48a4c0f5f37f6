#include "gltf_ext/document/check_structure.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include "gltf_ext/document/check_scene.h"
#include "gltf_ext/document/element_layout.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

std::string numbered(const char* what, size_t index) { return std::string(what) + " " + std::to_string(index); }

// A byte count or offset. It is at most 2^53, so that no sum of two overflows.
std::optional<uint64_t> size_field(const Json& object, const char* name, int64_t fallback) {
  const auto value = integer_field_or(object, name, fallback);
  constexpr int64_t kMost = int64_t{1} << 53;
  if (!value || *value < 0 || *value > kMost) return std::nullopt;
  return static_cast<uint64_t>(*value);
}

bool in_range(const Json& index, size_t size) {
  const auto value = integer_value(index);
  return value && *value >= 0 && static_cast<uint64_t>(*value) < size;
}

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

Status check_extensions(const Json& json) {
  const auto place = bad_extensions(json);
  if (!place) return {};
  return invalid_input((place->empty() ? "" : place->substr(1) + ": ") + "extensions is not an object");
}

// A range of a buffer: that of a view, or of the compressed bytes of a view.
Status check_buffer_range(const Json& json, const Json& range, const std::string& name) {
  const Json* index = field(range, "buffer");
  if (index == nullptr || !in_range(*index, array_size(json, "buffers")))
    return invalid_input(name + " names a buffer that does not exist");
  const auto buffer_bytes =
      size_field(json["buffers"][static_cast<size_t>(*integer_value(*index))], "byteLength", -1);
  const auto offset = size_field(range, "byteOffset", 0);
  const auto length = size_field(range, "byteLength", -1);
  if (!offset || !length) return invalid_input(name + " has no valid byteOffset and byteLength");
  if (!buffer_bytes || *offset + *length > *buffer_bytes)
    return invalid_input(name + " reaches past its buffer");
  return {};
}

Status check_buffers_and_views(const Json& json) {
  for (size_t i = 0; i < array_size(json, "buffers"); ++i) {
    const Json& buffer = json["buffers"][i];
    if (!size_field(buffer, "byteLength", -1))
      return invalid_input(numbered("buffer", i) + " has no valid byteLength");
    if (field(buffer, "uri") != nullptr && string_field(buffer, "uri") == nullptr)
      return invalid_input(numbered("buffer", i) + " has a uri that is not a string");
  }
  for (size_t i = 0; i < array_size(json, "bufferViews"); ++i) {
    const Json& view = json["bufferViews"][i];
    const std::string name = numbered("buffer view", i);
    if (Status status = check_buffer_range(json, view, name); !status.ok()) return status;
    const auto stride = size_field(view, "byteStride", 0);
    if (!stride || *stride > 252 || *stride > size_field(view, "byteLength", 0).value_or(0))
      return invalid_input(name + " has an invalid byteStride");
    if (const Json* meshopt = meshopt_extension(view)) {
      Status status = check_buffer_range(json, *meshopt, name + ", compressed,");
      if (!status.ok()) return status;
    }
  }
  return {};
}

Status check_elements(const Json& json, const Json& view_index, const ElementLayout& layout, uint64_t offset,
                      uint64_t count, bool strided, const std::string& name) {
  if (!in_range(view_index, array_size(json, "bufferViews")))
    return invalid_input(name + " names a buffer view that does not exist");
  const Json& view = json["bufferViews"][static_cast<size_t>(*integer_value(view_index))];
  uint64_t stride = strided ? size_field(view, "byteStride", 0).value_or(0) : 0;
  if (stride == 0) stride = layout.stored_bytes();
  if (stride < layout.last_bytes())
    return invalid_input(name + " has elements longer than its buffer view's stride");
  if (!elements_fit(layout, offset, stride, count, size_field(view, "byteLength", 0).value_or(0)))
    return invalid_input(name + " reaches past its buffer view");
  return {};
}

Status check_sparse(const Json& json, const Json& sparse, const ElementLayout& layout, uint64_t count,
                    const std::string& name) {
  const auto sparse_count = size_field(sparse, "count", -1);
  const Json* indices = object_field(sparse, "indices");
  const Json* values = object_field(sparse, "values");
  if (!sparse_count || *sparse_count > count || indices == nullptr || values == nullptr)
    return invalid_input(name + " has no valid count, indices or values");
  Json index_accessor = {{"type", "SCALAR"}};
  if (const Json* type = field(*indices, "componentType")) index_accessor["componentType"] = *type;
  const auto index_layout = element_layout(index_accessor);
  if (!index_layout) return invalid_input(name + " has an invalid index type");
  for (const auto& [part, part_layout] : {std::pair(indices, *index_layout), std::pair(values, layout)}) {
    const Json* view = field(*part, "bufferView");
    const auto offset = size_field(*part, "byteOffset", 0);
    if (view == nullptr || !offset) return invalid_input(name + " has no buffer view or no valid byteOffset");
    Status status = check_elements(json, *view, part_layout, *offset, *sparse_count, false, name);
    if (!status.ok()) return status;
  }
  return {};
}

Status check_accessors(const Json& json) {
  for (size_t i = 0; i < array_size(json, "accessors"); ++i) {
    const Json& accessor = json["accessors"][i];
    const std::string name = numbered("accessor", i);
    const auto layout = element_layout(accessor);
    if (!layout) return invalid_input(name + ": " + layout.status().message());
    const auto count = size_field(accessor, "count", -1);
    if (!count || *count > UINT32_MAX) return invalid_input(name + " has no valid count");
    const auto offset = size_field(accessor, "byteOffset", 0);
    if (!offset) return invalid_input(name + " has an invalid byteOffset");
    if (const Json* view = field(accessor, "bufferView")) {
      Status status = check_elements(json, *view, *layout, *offset, *count, true, name);
      if (!status.ok()) return status;
    }
    if (const Json* sparse = field(accessor, "sparse")) {
      Status status = check_sparse(json, *sparse, *layout, *count, name + ", sparse,");
      if (!status.ok()) return status;
    }
  }
  return {};
}

// The types of attributes whose names glTF defines. Component types are not checked, because extensions allow
// more of them than glTF.
Status check_attribute_types(const Json& json, const Json& attributes) {
  struct Type {
    std::string_view prefix;
    std::vector<std::string_view> types;
  };
  static const Type kTypes[] = {{"POSITION", {"VEC3"}},  {"NORMAL", {"VEC3"}},         {"TANGENT", {"VEC4"}},
                                {"TEXCOORD_", {"VEC2"}}, {"COLOR_", {"VEC3", "VEC4"}}, {"JOINTS_", {"VEC4"}},
                                {"WEIGHTS_", {"VEC4"}}};
  int sets = 0;  // sets of joints minus sets of weights
  for (const auto& [semantic, index] : attributes.items()) {
    sets += (semantic.starts_with("JOINTS_") ? 1 : 0) - (semantic.starts_with("WEIGHTS_") ? 1 : 0);
    const Json* accessor = top_level_object(json, "accessors", integer_value(index).value_or(-1));
    const std::string* type = accessor == nullptr ? nullptr : string_field(*accessor, "type");
    if (type == nullptr) continue;
    for (const auto& [prefix, types] : kTypes)
      if (semantic.starts_with(prefix) && std::find(types.begin(), types.end(), *type) == types.end())
        return invalid_input(semantic + " is of type " + *type);
  }
  if (sets != 0) return invalid_input("the numbers of JOINTS and WEIGHTS attributes differ");
  return {};
}

Status check_primitive(const Json& json, const Json& primitive) {
  const Json* attributes = object_field(primitive, "attributes");
  if (attributes == nullptr) return invalid_input("no attributes");
  const Json* targets = field(primitive, "targets");
  if (targets != nullptr && !targets->is_array()) return invalid_input("targets is not an array");
  for (size_t t = 0; targets != nullptr && t < targets->size(); ++t)
    if (!(*targets)[t].is_object()) return invalid_input("targets is not an array of objects");
  return check_attribute_types(json, *attributes);
}

Status check_meshes(const Json& json) {
  for (size_t i = 0; i < array_size(json, "meshes"); ++i) {
    Place place{.mesh = static_cast<int64_t>(i)};
    const Json* primitives = array_field(json["meshes"][i], "primitives");
    if (primitives == nullptr) return invalid_input("no array of primitives", place);
    for (size_t p = 0; p < primitives->size(); ++p) {
      place.primitive = static_cast<int64_t>(p);
      if (Status status = check_primitive(json, (*primitives)[p]); !status.ok())
        return std::move(status).at(place);
      const size_t targets = array_size((*primitives)[p], "targets"),
                   first = array_size((*primitives)[0], "targets");
      if (targets != first)
        return invalid_input(std::to_string(targets) + " morph targets, but the mesh's first primitive has " +
                                 std::to_string(first),
                             place);
    }
  }
  return {};
}

Status check_references(const Json& json) {
  const size_t accessors = array_size(json, "accessors");
  const size_t views = array_size(json, "bufferViews");
  bool accessors_exist = true;
  for_each_accessor_reference(json, [&](const Json& index) { accessors_exist &= in_range(index, accessors); });
  if (!accessors_exist)
    return invalid_input("a mesh, animation, skin or node names an accessor that does not exist");
  bool views_exist = true;
  for_each_buffer_view_reference(json, [&](const Json& index) { views_exist &= in_range(index, views); });
  if (!views_exist) return invalid_input("an image or an extension names a buffer view that does not exist");
  return {};
}

}  // namespace

Status check_structure(const Json& json) {
  for (const auto check : {check_version, check_arrays, check_extensions, check_buffers_and_views,
                           check_accessors, check_meshes, check_references, check_scene})
    if (Status status = check(json); !status.ok()) return status;
  return {};
}

}  // namespace psplit
