#include "gltf_ext/document/unknown_references.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "gltf_ext/document/references.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

// Whether all references of an extension to accessors and buffer views are known here. Most have none.
bool is_understood(std::string_view name) {
  constexpr std::string_view kKnown[] = {"KHR_materials_*",
                                         "KHR_texture_*",
                                         "EXT_texture_*",
                                         "MSFT_texture_*",
                                         "MSFT_packing_*",
                                         "MSFT_lod",
                                         "EXT_materials_*",
                                         "ADOBE_materials_*",
                                         "KHR_lights_*",
                                         "EXT_lights_*",
                                         "KHR_mesh_quantization",
                                         "KHR_xmp*",
                                         "KHR_animation_pointer",
                                         "KHR_node_*",
                                         "KHR_techniques_webgl",
                                         "KHR_meshopt_compression",
                                         "EXT_meshopt_compression",
                                         "KHR_draco_mesh_compression",
                                         "PSPLIT_mesh_draco_patches",
                                         "EXT_mesh_gpu_instancing",
                                         "EXT_structural_metadata",
                                         "EXT_mesh_features",
                                         "EXT_instance_features",
                                         "CESIUM_RTC",
                                         "CESIUM_primitive_outline",
                                         "AGI_articulations",
                                         "AGI_stk_metadata",
                                         "FB_ngon_encoding",
                                         "VRM",
                                         "VRMC_*",
                                         "GODOT_single_root"};
  return std::any_of(std::begin(kKnown), std::end(kKnown), [&](std::string_view known) {
    if (!known.ends_with('*')) return name == known;
    known.remove_suffix(1);
    return name.starts_with(known);
  });
}

constexpr const char* kManifold = "EXT_mesh_manifold";

// What the integers of a member may be.
struct Kinds {
  bool accessor = false, view = false, buffer = false;
  bool only_alone = false;  // and not in an array or an object

  bool any() const { return accessor || view || buffer; }
};

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}

// Visits the words of a name: "myBufferView" and "my_buffer_view" are "my", "buffer" and "view". Longer words
// than any that is looked for are left out.
template <typename Visit>
void for_each_word(std::string_view name, const Visit& visit) {
  std::array<char, 16> word;
  size_t size = 0;
  const auto finish = [&] {
    if (size > 0 && size <= word.size()) visit(std::string_view(word.data(), size));
    size = 0;
  };
  bool was_lower = false;
  for (const char c : name) {
    const bool is_upper = c >= 'A' && c <= 'Z', is_lower = c >= 'a' && c <= 'z';
    if ((is_upper && was_lower) || !(is_upper || is_lower)) finish();
    if (is_upper || is_lower) {
      if (size < word.size()) word[size] = is_upper ? static_cast<char>(c - 'A' + 'a') : c;
      ++size;
    }
    was_lower = is_lower;
  }
  finish();
}

Kinds kinds_of_name(std::string_view name, bool in_extension) {
  Kinds kinds;
  for_each_word(name, [&](std::string_view word) {
    if (is_one_of(word, {"accessor", "accessors", "indices", "attribute", "attributes"})) kinds.accessor = true;
    if (is_one_of(word, {"view", "views", "bufferview", "bufferviews"})) kinds.view = true;
    if (is_one_of(word, {"buffer", "buffers"})) kinds.buffer = true;
    if (in_extension && is_one_of(word, {"values", "offsets", "positions", "normals", "tangents", "vertices",
                                         "matrices", "input", "output"}))
      kinds.only_alone = true;
  });
  if (kinds.view) kinds.buffer = false;  // "bufferView"
  if (kinds.any()) kinds.only_alone = false;
  if (kinds.only_alone) kinds.accessor = kinds.view = true;
  return kinds;
}

// Members of objects that describe data, such as accessors and views, and indices of other objects.
bool is_never_an_index_of_data(std::string_view name) {
  return is_one_of(name, {"count",   "byteOffset", "byteLength", "byteStride", "componentType", "type",
                          "mode",    "size",       "length",     "offset",     "stride",        "min",
                          "max",     "version",    "id",         "mesh",       "node",          "nodes",
                          "scene",   "skin",       "camera",     "material",   "texture",       "image",
                          "sampler", "source",     "texCoord",   "index",      "target",        "channel"});
}

// References that glTF has itself; gltf_ext/document/references.h knows them.
bool is_known_member(std::string_view name) {
  return is_one_of(
      name, {"accessors", "buffers", "bufferViews", "bufferView", "buffer", "indices", "attributes", "targets",
             "input", "output", "inverseBindMatrices", "sparse", "values"});
}

class Finder {
 public:
  // Objects of glTF and of known extensions.
  void find_in_known(const Json& tree, bool in_extension) {
    if (!tree.is_structured()) return;
    const auto* const members = tree.get_ptr<const Json::object_t*>();
    if (members == nullptr) {
      for (const Json& element : tree) find_in_known(element, in_extension);
      return;
    }
    constexpr std::string_view kExtras = "extras", kExtensions = "extensions";
    for (const auto& [key, member] : *members) {
      if (!member.is_structured() && !member.is_number_integer()) continue;
      if (key == kExtras) {
        find_in_unknown(member, {}, false);
      } else if (key == kExtensions && member.is_object()) {
        find_in_extensions(member);
      } else if (!in_extension && !is_known_member(key)) {
        if (const Kinds kinds = kinds_of_name(key, false); kinds.any())
          find_in_unknown(member, kinds, false);
        else
          find_in_known(member, in_extension);
      } else {
        find_in_known(member, in_extension);
      }
    }
  }

  // Data of others, in a member whose integers may be of these kinds.
  void find_in_unknown(const Json& tree, Kinds kinds, bool in_extension) {
    if (const auto index = integer_value(tree); index && *index >= 0) {
      if (kinds.accessor) found_.accessors.insert(*index);
      if (kinds.view) found_.views.insert(*index);
      if (kinds.buffer) found_.buffers.insert(*index);
    }
    if (!tree.is_structured()) return;
    if (kinds.only_alone) kinds = {};
    const bool is_object = tree.is_object();
    for (auto member = tree.begin(); member != tree.end(); ++member) {
      Kinds own = kinds;
      if (is_object) {
        if (const Kinds named = kinds_of_name(member.key(), in_extension); named.any()) own = named;
        if (is_never_an_index_of_data(member.key())) own = {};
      }
      find_in_unknown(*member, own, in_extension);
    }
  }

  UnknownReferences found() && { return std::move(found_); }

 private:
  void find_in_extensions(const Json& extensions) {
    for (auto extension = extensions.begin(); extension != extensions.end(); ++extension) {
      if (is_understood(extension.key())) {
        find_in_known(*extension, true);
      } else {
        found_.has_unknown_extensions = true;
        // encode drops this one, and nothing else changes the accessors that belong to it alone.
        if (extension.key() == kManifold) continue;
        find_in_unknown(*extension, {}, true);
      }
    }
  }

  UnknownReferences found_;
};

}  // namespace

UnknownReferences find_unknown_references(const Json& json) {
  Finder finder;
  finder.find_in_known(json, false);
  return std::move(finder).found();
}

DataUsers::DataUsers(const Json& json) {
  for_each_accessor_reference(json, [&](const Json& index) { ++accessors[integer_value(index).value_or(-1)]; });
  for_each_buffer_view_reference(json, [&](const Json& index) { ++views[integer_value(index).value_or(-1)]; });
  const UnknownReferences unknown = find_unknown_references(json);
  for (const int64_t named : unknown.accessors) ++accessors[named];
  for (const int64_t named : unknown.views) ++views[named];
}

const char* unknown_extension_with_accessors(const Json& object) {
  const Json* extensions = object_field(object, "extensions");
  if (extensions == nullptr) return nullptr;
  for (auto extension = extensions->begin(); extension != extensions->end(); ++extension) {
    if (is_understood(extension.key()) || extension.key() == kManifold) continue;
    Finder finder;
    finder.find_in_unknown(*extension, {}, true);
    if (!std::move(finder).found().accessors.empty()) return extension.key().c_str();
  }
  return nullptr;
}

}  // namespace psplit
