#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/read_steps.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

// The types of attributes whose names glTF defines. Component types are not checked, because extensions allow
// more of them than glTF.
Status check_attribute_types(const AssetRecords& records, const AttributeRecords& attributes) {
  struct Type {
    std::string_view prefix;
    std::vector<std::string_view> types;
  };
  static const Type kTypes[] = {{"POSITION", {"VEC3"}},  {"NORMAL", {"VEC3"}},         {"TANGENT", {"VEC4"}},
                                {"TEXCOORD_", {"VEC2"}}, {"COLOR_", {"VEC3", "VEC4"}}, {"JOINTS_", {"VEC4"}},
                                {"WEIGHTS_", {"VEC4"}}};
  int sets = 0;  // sets of joints minus sets of weights
  for (const auto& [semantic, index] : attributes) {
    sets += (semantic.starts_with("JOINTS_") ? 1 : 0) - (semantic.starts_with("WEIGHTS_") ? 1 : 0);
    const std::string_view type = type_name(records.accessor(index).layout);
    for (const auto& [prefix, types] : kTypes)
      if (semantic.starts_with(prefix) && std::find(types.begin(), types.end(), type) == types.end())
        return invalid_input(semantic + " is of type " + std::string(type));
  }
  if (sets != 0) return invalid_input("the numbers of JOINTS and WEIGHTS attributes differ");
  return {};
}

Status check_primitives(const Document& document) {
  const AssetRecords& records = document.records();
  for (const PrimitiveId id : all_primitives(document)) {
    const Place place = place_of(id);
    const PrimitiveRecord& primitive = records.primitive(id);
    if (Status status = check_attribute_types(records, primitive.attributes); !status.ok())
      return std::move(status).at(place);
    const size_t targets = primitive.targets.size(), first = records.meshes[id.mesh][0].targets.size();
    if (targets != first)
      return invalid_input(std::to_string(targets) + " morph targets, but the mesh's first primitive has " +
                               std::to_string(first),
                           place);
  }
  return {};
}

// A member that holds an index, and the top-level array that it indexes. [] means every element.
struct Reference {
  std::string_view path;
  const char* target;
};
constexpr Reference kReferences[] = {
    {"scene", "scenes"},
    {"scenes[].nodes[]", "nodes"},
    {"nodes[].children[]", "nodes"},
    {"nodes[].mesh", "meshes"},
    {"nodes[].skin", "skins"},
    {"nodes[].camera", "cameras"},
    {"skins[].joints[]", "nodes"},
    {"skins[].skeleton", "nodes"},
    {"meshes[].primitives[].material", "materials"},
    {"meshes[].extensions.PSPLIT_mesh_draco_patches.primitives[].material", "materials"},
    {"materials[].pbrMetallicRoughness.baseColorTexture.index", "textures"},
    {"materials[].pbrMetallicRoughness.metallicRoughnessTexture.index", "textures"},
    {"materials[].normalTexture.index", "textures"},
    {"materials[].occlusionTexture.index", "textures"},
    {"materials[].emissiveTexture.index", "textures"},
    {"textures[].source", "images"},
    {"textures[].sampler", "samplers"},
    {"animations[].channels[].target.node", "nodes"},
};

// Finds the values that `path` leads to from `tree`. Returns the place of the first value for which
// is_good(value) is false, as in nodes[3].children[0], or an empty string.
template <typename Check>
std::string first_bad(const Json& tree, std::string_view path, const Check& is_good) {
  if (path.empty()) return is_good(tree) ? "" : " ";
  if (path.starts_with('[')) {
    if (!tree.is_array()) return "";
    for (size_t i = 0; i < tree.size(); ++i) {
      const std::string place = first_bad(tree[i], path.substr(2), is_good);
      if (!place.empty()) return "[" + std::to_string(i) + "]" + place;
    }
    return "";
  }
  if (path.starts_with('.')) path.remove_prefix(1);
  const std::string name(path.substr(0, path.find_first_of(".[")));
  const Json* member = field(tree, name.c_str());
  if (member == nullptr) return "";
  const std::string place = first_bad(*member, path.substr(name.size()), is_good);
  return place.empty() ? "" : "." + name + place;
}

bool is_index(const Json& value, size_t count) {
  const auto index = integer_value(value);
  return index && *index >= 0 && static_cast<uint64_t>(*index) < count;
}

Status check_index(const Json& tree, const std::string& where, std::string_view path, const char* target,
                   size_t count) {
  std::string place = first_bad(tree, path, [&](const Json& value) { return is_index(value, count); });
  if (place.empty()) return {};
  place = where + place.substr(where.empty() ? 1 : 0, place.size() - (where.empty() ? 2 : 1));
  return invalid_input(place + " is not the index of one of the " + std::to_string(count) + " " + target);
}

Status check_references(const Document& document) {
  const Json& json = document.json();
  for (const auto& [path, target] : kReferences)
    if (Status status = check_index(json, "", path, target, array_size(json, target)); !status.ok())
      return status;
  for (size_t i = 0; i < array_size(json, "animations"); ++i) {
    const Json& animation = json["animations"][i];
    Status status = check_index(animation, "animations[" + std::to_string(i) + "]", "channels[].sampler",
                                "samplers of the animation", array_size(animation, "samplers"));
    if (!status.ok()) return status;
  }
  return {};
}

// Checks that no node is its own descendant. A node with two parents is against the rules too, but occurs in
// practice and lets every walk end: it is allowed.
Status check_nodes(const Document& document) {
  const Json& json = document.json();
  const size_t count = array_size(json, "nodes");
  enum class Walk : uint8_t { kNotYet, kUnderWay, kDone };
  std::vector<Walk> walks(count, Walk::kNotYet);
  std::vector<std::pair<size_t, size_t>> way;  // the nodes from the start downwards, and the next child of each
  for (size_t start = 0; start < count; ++start) {
    if (walks[start] == Walk::kNotYet) way.emplace_back(start, 0);
    while (!way.empty()) {
      auto& [node, next] = way.back();
      walks[node] = Walk::kUnderWay;
      if (next == array_size(json["nodes"][node], "children")) {
        walks[node] = Walk::kDone;
        way.pop_back();
        continue;
      }
      const auto child = static_cast<size_t>(*integer_value(json["nodes"][node]["children"][next++]));
      if (walks[child] == Walk::kUnderWay)
        return invalid_input("node " + std::to_string(child) + " is its own descendant");
      if (walks[child] == Walk::kNotYet) way.emplace_back(child, 0);
    }
  }
  return {};
}

Status check_skins(const Document& document) {
  const Json& json = document.json();
  for (size_t i = 0; i < array_size(json, "skins"); ++i) {
    const Json& skin = json["skins"][i];
    const Json* joints = array_field(skin, "joints");
    const std::string name = "skin " + std::to_string(i);
    if (joints == nullptr || joints->empty()) return invalid_input(name + " has no joints");
    const auto matrices = integer_field(skin, "inverseBindMatrices");
    if (matrices && document.records().accessor(*matrices).count < joints->size())
      return invalid_input(name + " has fewer inverse bind matrices than joints");
  }
  return {};
}

}  // namespace

Status check_scene(const Document& document) {
  for (const auto check : {check_primitives, check_references, check_nodes, check_skins})
    if (Status status = check(document); !status.ok()) return status;
  return {};
}

}  // namespace psplit
