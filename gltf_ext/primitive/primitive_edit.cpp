#include "gltf_ext/primitive/primitive_edit.h"

#include <algorithm>
#include <cstring>

#include "gltf_ext/document/drop_unused.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;

}  // namespace

std::vector<PrimitiveGroup> group_equal_primitives(const Document& document,
                                                   const std::vector<PrimitiveId>& ids) {
  std::vector<PrimitiveGroup> groups;
  std::map<std::string, size_t> group_of;
  for (const PrimitiveId id : ids) {
    const Json& primitive = document.json["meshes"][id.mesh]["primitives"][id.primitive];
    Json geometry = Json::array();
    for (const char* name : {"attributes", "indices", "mode", "targets"}) {
      const Json* member = field(primitive, name);
      geometry.push_back(member == nullptr ? Json() : *member);
    }
    for (const char* name : {kExtensionName, kStockExtensionName}) {
      const Json* extension = extension_field(primitive, name);
      geometry.push_back(extension == nullptr ? Json() : *extension);
    }
    const auto [found, is_new] = group_of.emplace(geometry.dump(), groups.size());
    if (is_new) groups.emplace_back();
    groups[found->second].ids.push_back(id);
  }
  return groups;
}

Json& primitive_json(Document& document, PrimitiveId id) {
  return document.json["meshes"][id.mesh]["primitives"][id.primitive];
}

PrimitiveEditor::PrimitiveEditor(Document& document) : document_(document) {
  for_each_accessor_reference(document.json, [&](const Json& index) {
    if (const auto number = integer_value(index)) ++users_[*number];
  });
}

// The accessor that may hold the group's data for a role. Each primitive names it `uses` times. Returns the
// current accessor if nothing else uses it, otherwise a copy of it.
int64_t PrimitiveEditor::accessor_to_edit(const PrimitiveGroup& group, const std::string& role,
                                          const Json* current, size_t uses) {
  const size_t users = group.ids.size() * uses;
  Json& accessors = document_.json["accessors"];
  if (!accessors.is_array()) accessors = Json::array();
  const auto index = current == nullptr ? std::nullopt : integer_value(*current);
  Json fresh = Json::object();
  if (index) {
    const auto taken = taken_.find(*index);
    if (users_[*index] == users && taken == taken_.end()) {
      taken_[*index] = role;
      return *index;
    }
    users_[*index] -= std::min(users_[*index], users);
    if (users_[*index] == 0 && taken == taken_.end()) freed_.push_back(*index);
    fresh = accessors[static_cast<size_t>(*index)];
  }
  accessors.push_back(std::move(fresh));
  const auto added = static_cast<int64_t>(accessors.size()) - 1;
  users_[added] = users;
  taken_[added] = role;
  return added;
}

void PrimitiveEditor::fill(int64_t index, const ValuesView& data, int target, GeometryData how,
                           bool with_bounds, const Placed* placed) {
  const auto slot = static_cast<size_t>(index);
  with_bounds = with_bounds || field(document_.json["accessors"][slot], "min") != nullptr;
  Json& accessor = document_.json["accessors"][slot];
  describe_decoded(accessor, data, with_bounds);
  accessor["componentType"] = static_cast<int>(data.component_type);
  if (field(accessor, "type") == nullptr) accessor["type"] = "SCALAR";
  if (placed != nullptr)
    place_values(document_, accessor, data, target, placed->buffer, placed->offset);
  else if (how == GeometryData::kInBufferViews)
    store_values(document_, accessor, data, target);
  if (how == GeometryData::kSparse) store_values_sparse(document_, accessor, data, target);
}

void PrimitiveEditor::set_attribute(const PrimitiveGroup& group, const MeshView::Values& attribute,
                                    GeometryData data, const Placed* placed) {
  const std::string& semantic = attribute.semantic;
  const Json& attributes = primitive_json(document_, group.ids.front())["attributes"];
  const int64_t index = accessor_to_edit(group, semantic, field(attributes, semantic.c_str()));
  fill(index, attribute.values, kArrayBuffer, data, semantic == "POSITION", placed);
  for (const PrimitiveId id : group.ids) primitive_json(document_, id)["attributes"][semantic] = index;
}

void PrimitiveEditor::set_indices(const PrimitiveGroup& group, const ValuesView& indices, GeometryData data,
                                  const Placed* placed) {
  const int64_t index =
      accessor_to_edit(group, "indices", field(primitive_json(document_, group.ids.front()), "indices"));
  fill(index, indices, kElementArrayBuffer, data, false, placed);
  for (const PrimitiveId id : group.ids) {
    Json& primitive = primitive_json(document_, id);
    primitive["indices"] = index;
    if (integer_field_or(primitive, "mode", 4) != 4) primitive["mode"] = 4;
  }
}

void PrimitiveEditor::set_geometry(const PrimitiveGroup& group, const Mesh& mesh,
                                   const std::vector<MorphAttribute>& morphs, GeometryData data,
                                   const std::vector<std::string>& only) {
  for (const MeshView::Values& attribute : view_of(mesh).attributes)
    if (only.empty() || std::ranges::find(only, attribute.semantic) != only.end())
      set_attribute(group, attribute, data, nullptr);
  set_indices(group, index_data(mesh), data, nullptr);
  set_morphs(group, morphs);
}

void PrimitiveEditor::set_placed_geometry(const PrimitiveGroup& group, const PlacedMesh& mesh) {
  for (size_t i = 0; i < mesh.view.attributes.size(); ++i) {
    const Placed placed{mesh.buffer, mesh.offsets[i]};
    set_attribute(group, mesh.view.attributes[i], GeometryData::kInBufferViews, &placed);
  }
  const Placed placed{mesh.buffer, mesh.offsets.back()};
  set_indices(group, mesh.view.indices, GeometryData::kInBufferViews, &placed);
}

void PrimitiveEditor::set_morphs(const PrimitiveGroup& group, const std::vector<MorphAttribute>& morphs) {
  const auto current = [&](const MorphAttribute& morph) {
    return field(primitive_json(document_, group.ids.front())["targets"][morph.target], morph.semantic.c_str());
  };
  std::map<int64_t, size_t> uses;
  for (const MorphAttribute& morph : morphs) ++uses[integer_value(*current(morph)).value_or(-1)];
  std::map<int64_t, int64_t> edited;
  for (const MorphAttribute& morph : morphs) {
    const int64_t before = integer_value(*current(morph)).value_or(-1);
    const auto [found, is_new] = edited.try_emplace(before, 0);
    if (is_new) {
      const std::string role = "target " + std::to_string(morph.target) + " " + morph.semantic;
      found->second = accessor_to_edit(group, role, current(morph), uses[before]);
      fill(found->second, morph.data, kArrayBuffer,
           morph.sparse ? GeometryData::kSparse : GeometryData::kInBufferViews, morph.semantic == "POSITION");
    }
    const int64_t index = found->second;
    for (const PrimitiveId id : group.ids)
      primitive_json(document_, id)["targets"][morph.target][morph.semantic] = index;
  }
}

void PrimitiveEditor::finish() {
  drop_unused(document_, freed_);
  for (const char* name : {kExtensionName, kStockExtensionName}) unlist_unused_extension(document_, name);
}

}  // namespace psplit
