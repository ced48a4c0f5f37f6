#include "gltf_ext/primitive/primitive_edit.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "gltf_ext/document/drop_unused.h"
#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/document/unknown_references.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

// What two Draco extensions have in common if they store the same data.
using DracoKey = std::tuple<int64_t, std::vector<std::pair<std::string, uint32_t>>, std::string>;

DracoKey key_of(const std::optional<DracoRecord>& draco) {
  DracoKey key{-2, {}, ""};
  if (!draco) return key;
  auto& [view, ids, message] = key;
  view = draco->view;
  message = draco->status.message();
  for (const AttributeRequest& request : draco->requests) ids.emplace_back(request.semantic, request.unique_id);
  return key;
}

}  // namespace

std::vector<PrimitiveGroup> group_equal_primitives(const Document& document,
                                                   const std::vector<PrimitiveId>& ids) {
  using Geometry =
      std::tuple<AttributeRecords, std::vector<AttributeRecords>, int64_t, int, DracoKey, DracoKey>;
  std::vector<PrimitiveGroup> groups;
  std::map<Geometry, size_t> group_of;
  for (const PrimitiveId id : ids) {
    const PrimitiveRecord& p = document.records().primitive(id);
    const auto [found, is_new] = group_of.emplace(
        Geometry{p.attributes, p.targets, p.indices, p.mode, key_of(p.patches), key_of(p.stock)},
        groups.size());
    if (is_new) groups.emplace_back();
    groups[found->second].ids.push_back(id);
  }
  return groups;
}

Json& primitive_json(Document& document, PrimitiveId id) {
  return document.json()["meshes"][id.mesh]["primitives"][id.primitive];
}
const Json& primitive_json(const Document& document, PrimitiveId id) {
  return document.json()["meshes"][id.mesh]["primitives"][id.primitive];
}

bool all_have_fallbacks(const Document& document, std::span<const PrimitiveId> ids) {
  std::map<size_t, bool> known;  // of the meshes
  const auto has_coarse = [&](size_t mesh) {
    const auto [found, is_new] = known.try_emplace(mesh, false);
    if (!is_new) return found->second;
    const Json* coarse = other_primitives(document.json()["meshes"][mesh]);
    return found->second =
               coarse != nullptr && std::none_of(coarse->begin(), coarse->end(), [](const Json& primitive) {
                 return extension_field(primitive, kExtensionName) != nullptr ||
                        extension_field(primitive, kStockExtensionName) != nullptr;
               });
  };
  const AssetRecords& records = document.records();
  return std::ranges::all_of(ids, [&](PrimitiveId id) {
    return records.has_plain_data(records.primitive(id)) || has_coarse(id.mesh);
  });
}

Json draco_extension(int64_t buffer_view, std::span<const AttributeRequest> requests, size_t target_count) {
  Json attributes = Json::object(), targets = Json::object();
  for (const AttributeRequest& request : requests) {
    const std::optional<MorphTarget> target = target_of(request.semantic);
    if (!target) {
      attributes[request.semantic] = request.unique_id;
      continue;
    }
    Json& ids = targets[target->semantic];
    if (!ids.is_array()) ids = Json::array_t(target_count, -1);
    ids[target->number] = request.unique_id;
  }
  Json extension{{"bufferView", buffer_view}, {"attributes", std::move(attributes)}};
  if (!targets.empty()) extension["targets"] = std::move(targets);
  return extension;
}

void set_draco_extension(Document& document, const PrimitiveGroup& group, const char* name, int64_t buffer_view,
                         std::span<const AttributeRequest> requests) {
  // Not from the records, which are read again after each edit.
  const size_t targets = array_size(primitive_json(std::as_const(document), group.ids.front()), "targets");
  const Json extension = draco_extension(buffer_view, requests, targets);
  for (const PrimitiveId id : group.ids) {
    Json& primitive = primitive_json(document, id);
    if (Json* extensions = object_field(primitive, "extensions"))
      for (const char* other : {kExtensionName, kStockExtensionName}) extensions->erase(other);
    primitive["extensions"][name] = extension;
  }
}

void rename_draco_extension(Document& document, std::span<const PrimitiveId> ids, const char* from,
                            const char* to) {
  if (ids.empty()) return;
  const bool is_required = !all_have_fallbacks(document, ids);
  for (const PrimitiveId id : ids) {
    Json& extensions = primitive_json(document, id)["extensions"];
    Json renamed = Json::object();  // in the same order
    for (auto& [name, extension] : extensions.items())
      if (name != to) renamed[name == from ? to : name] = std::move(extension);
    extensions = std::move(renamed);
  }
  list_extension(document, to, is_required);
}

std::vector<std::vector<PrimitiveGroup>> repeat_primitives(Document& document,
                                                           std::span<const PrimitiveGroup> groups,
                                                           std::span<const size_t> counts) {
  std::map<PrimitiveId, size_t> group_of;
  std::vector<std::vector<PrimitiveGroup>> repeated(groups.size());
  for (size_t i = 0; i < groups.size(); ++i) {
    repeated[i].resize(counts[i]);
    for (const PrimitiveId id : groups[i].ids) group_of[id] = i;
  }
  if (groups.empty()) return repeated;
  Json& meshes = document.json()["meshes"];
  for (size_t m = 0; m < meshes.size(); ++m) {
    Json& primitives = meshes[m]["primitives"];
    Json all = Json::array();
    for (size_t p = 0; p < primitives.size(); ++p) {
      const auto found = group_of.find({m, p});
      if (found == group_of.end()) {
        all.push_back(std::move(primitives[p]));
        continue;
      }
      for (PrimitiveGroup& group : repeated[found->second]) {
        group.ids.push_back({m, all.size()});
        all.push_back(primitives[p]);
      }
    }
    primitives = std::move(all);
  }
  return repeated;
}

PrimitiveEditor::PrimitiveEditor(Document& document) : document_(document) {
  for_each_accessor_reference(document.json(), [&](const Json& index) {
    if (const auto number = integer_value(index)) ++users_[*number];
  });
  // An accessor without data of its own describes what the primitive stores: that goes on.
  for (const int64_t named : find_unknown_references(std::as_const(document).json()).accessors)
    if (const Json* accessor = top_level_object(document.json(), "accessors", named);
        accessor != nullptr && (accessor->contains("bufferView") || accessor->contains("sparse")))
      ++users_[named];
}

// The accessor that may hold the group's data for a role. Each primitive names it `uses` times. Returns the
// current accessor if nothing else uses it, otherwise a copy of it.
int64_t PrimitiveEditor::accessor_to_edit(const PrimitiveGroup& group, const std::string& role,
                                          const Json* current, size_t uses) {
  const size_t users = group.ids.size() * uses;
  Json& accessors = document_.json()["accessors"];
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
                           bool with_bounds, const Placed* placed, const Bounds* bounds) {
  const auto slot = static_cast<size_t>(index);
  meshopt_.lose(document_, index);
  with_bounds = with_bounds || field(document_.json()["accessors"][slot], "min") != nullptr;
  Json& accessor = document_.json()["accessors"][slot];
  if (bounds != nullptr && with_bounds) {
    for (const char* name : {"bufferView", "byteOffset", "sparse"}) accessor.erase(name);
    accessor["count"] = data.count;
    accessor["min"] = bounds->least;
    accessor["max"] = bounds->most;
  } else {
    describe_decoded(accessor, data, with_bounds && bounds == nullptr);
  }
  accessor["componentType"] = static_cast<int>(data.component_type);
  if (field(accessor, "type") == nullptr) accessor["type"] = "SCALAR";
  if (placed != nullptr)
    place_values(document_, accessor, data, target, placed->buffer, placed->offset);
  else if (how == GeometryData::kInBufferViews)
    store_values(document_, accessor, data, target);
  if (how == GeometryData::kSparse) store_values_sparse(document_, accessor, data, target);
}

void PrimitiveEditor::set_attribute(const PrimitiveGroup& group, const MeshView::Values& attribute,
                                    GeometryData data, const Placed* placed, const Bounds* bounds) {
  const std::optional<MorphTarget> target = target_of(attribute.semantic);
  const std::string& semantic = target ? target->semantic : attribute.semantic;
  const auto list = [&](PrimitiveId id) -> Json& {
    Json& primitive = primitive_json(document_, id);
    return target ? primitive["targets"][target->number] : primitive["attributes"];
  };
  const int64_t index =
      accessor_to_edit(group, attribute.semantic, field(list(group.ids.front()), semantic.c_str()));
  fill(index, attribute.values, kArrayBuffer, data, semantic == "POSITION", placed, bounds);
  for (const PrimitiveId id : group.ids) list(id)[semantic] = index;
}

void PrimitiveEditor::set_indices(const PrimitiveGroup& group, const ValuesView& indices, GeometryData data,
                                  const Placed* placed, const Bounds* bounds) {
  const int64_t index =
      accessor_to_edit(group, "indices", field(primitive_json(document_, group.ids.front()), "indices"));
  fill(index, indices, kElementArrayBuffer, data, false, placed, bounds);
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
  set_indices(group, IndexData(mesh), data, nullptr);
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

void PrimitiveEditor::set_geometry_in_file(const PrimitiveGroup& group, const MeshInFile& mesh) {
  const size_t buffer = append_buffer(document_, buffer_of(mesh.memory.view()));
  set_placed_geometry(group, {mesh.laid_out.view, buffer, mesh.laid_out.offsets});
}

void PrimitiveEditor::describe_geometry(const PrimitiveGroup& group, const MeshView& mesh,
                                        std::span<const Bounds> bounds) {
  for (size_t i = 0; i < mesh.attributes.size(); ++i)
    set_attribute(group, mesh.attributes[i], GeometryData::kStoredElsewhere, nullptr, &bounds[i]);
  set_indices(group, mesh.indices, GeometryData::kStoredElsewhere, nullptr, &bounds.back());
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
      const std::string role = name_of_target(morph.target, morph.semantic);
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
  meshopt_.compress_again(document_, freed_);
  drop_unused(document_, freed_);
  for (const char* name : {kExtensionName, kStockExtensionName}) unlist_unused_extension(document_, name);
  for (const char* name : kMeshoptExtensions) unlist_unused_extension(document_, name);
}

}  // namespace psplit
