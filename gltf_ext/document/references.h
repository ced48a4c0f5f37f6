// Every place in a glTF tree that holds the index of an accessor or of a buffer view.
#pragma once

#include <array>
#include <string_view>
#include <type_traits>

#include "gltf_ext/json/mesh_primitives.h"

namespace psplit {

// Calls visit(J& value) for all values of the member `name`, if it is an object.
template <AnyJson J, typename Visit>
void for_each_member(J& object, const char* name, Visit&& visit) {
  J* members = object_field(object, name);
  if (members == nullptr) return;
  for (auto& value : *members) visit(value);
}

template <AnyJson J, typename Visit>
void for_each_element(J& object, const char* name, Visit&& visit) {
  J* elements = array_field(object, name);
  if (elements == nullptr) return;
  for (auto& value : *elements) visit(value);
}

template <AnyJson J, typename Visit>
void visit_field(J& object, const char* name, Visit&& visit) {
  if (J* found = field(object, name)) visit(*found);
}

// Calls visit(J& index) for the accessor indices of a list of primitives: json["primitives"].
template <AnyJson J, typename Visit>
void for_each_accessor_of_primitives(J& json, Visit&& visit) {
  for_each_element(json, "primitives", [&](J& primitive) {
    for_each_member(primitive, "attributes", visit);
    visit_field(primitive, "indices", visit);
    for_each_element(primitive, "targets", [&](J& target) {
      if (!target.is_object()) return;
      for (auto& value : target) visit(value);
    });
    if (J* outline = extension_field(primitive, "CESIUM_primitive_outline"))
      visit_field(*outline, "indices", visit);
  });
}

// Calls visit(J& index) for the accessor indices of coarse primitives, which are in the extension of their
// mesh.
template <AnyJson J, typename Visit>
void for_each_coarse_reference(J& json, Visit&& visit) {
  for_each_element(json, "meshes", [&](J& mesh) {
    if (J* extension = extension_field(mesh, kExtensionName))
      for_each_accessor_of_primitives(*extension, visit);
  });
}

// Calls visit(J& index) for every accessor index.
template <AnyJson J, typename Visit>
void for_each_accessor_reference(J& json, Visit&& visit) {
  for_each_element(json, "meshes", [&](J& mesh) { for_each_accessor_of_primitives(mesh, visit); });
  for_each_coarse_reference(json, visit);
  for_each_element(json, "animations", [&](J& animation) {
    for_each_element(animation, "samplers", [&](J& sampler) {
      visit_field(sampler, "input", visit);
      visit_field(sampler, "output", visit);
    });
  });
  for_each_element(json, "skins", [&](J& skin) { visit_field(skin, "inverseBindMatrices", visit); });
  for_each_element(json, "nodes", [&](J& node) {
    if (J* instances = extension_field(node, "EXT_mesh_gpu_instancing"))
      for_each_member(*instances, "attributes", visit);
  });
}

// Calls visit(J& index) for members called "bufferView" at any depth, in every extension too, except in
// `extras`, which belong to the application.
template <AnyJson J, typename Visit>
void for_each_buffer_view_member(J& tree, Visit&& visit) {
  if (!tree.is_structured()) return;
  using Members = std::conditional_t<std::is_const_v<J>, const Json::object_t, Json::object_t>;
  auto* const members = tree.template get_ptr<Members*>();
  if (members == nullptr) {
    for (J& element : tree) for_each_buffer_view_member(element, visit);
    return;
  }
  constexpr std::string_view kExtras = "extras", kBufferView = "bufferView";
  for (auto& [key, member] : *members) {
    if (key == kBufferView)
      visit(member);
    else if (key != kExtras)
      for_each_buffer_view_member(member, visit);
  }
}

// Calls visit(J& index) for every buffer view index.
template <AnyJson J, typename Visit>
void for_each_buffer_view_reference(J& json, Visit&& visit) {
  for_each_buffer_view_member(json, visit);
  J* metadata = extension_field(json, "EXT_structural_metadata");
  if (metadata == nullptr) return;
  for_each_element(*metadata, "propertyTables", [&](J& table) {
    for_each_member(table, "properties", [&](J& property) {
      for (const char* name : {"values", "arrayOffsets", "stringOffsets"})
        if (J* found = field(property, name)) visit(*found);
    });
  });
}

}  // namespace psplit
