#include "gltf_ext/primitive/geometry_bytes.h"

#include <algorithm>
#include <numeric>
#include <set>

#include "gltf_ext/document/element_layout.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

uint64_t positive_field(const Json& object, const char* name) {
  return static_cast<uint64_t>(std::max<int64_t>(integer_field(object, name).value_or(0), 0));
}

// The bytes that an accessor stores: none if it has no buffer view, except for sparse values.
uint64_t accessor_bytes(const Json& accessor) {
  const auto layout = element_layout(accessor);
  if (!layout) return 0;
  uint64_t bytes = 0;
  if (field(accessor, "bufferView") != nullptr)
    bytes += positive_field(accessor, "count") * layout->stored_bytes();
  const Json* sparse = object_field(accessor, "sparse");
  const Json* indices = sparse == nullptr ? nullptr : object_field(*sparse, "indices");
  if (indices == nullptr) return bytes;
  Json index = *indices;
  index["type"] = "SCALAR";
  const auto index_layout = element_layout(index);
  const uint64_t index_bytes = index_layout ? index_layout->stored_bytes() : 0;
  return bytes + positive_field(*sparse, "count") * (index_bytes + layout->stored_bytes());
}

// Counts each accessor and each buffer view once.
class ByteCounter {
 public:
  explicit ByteCounter(const Json& json) : json_(json) {}

  uint64_t primitive(const Json& primitive) {
    uint64_t bytes = 0;
    for (const char* name : {kExtensionName, kStockExtensionName})
      if (const Json* extension = extension_field(primitive, name))
        if (const auto view = integer_field(*extension, "bufferView"); view && views_.insert(*view).second)
          if (const Json* found = top_level_object(json_, "bufferViews", *view))
            bytes += positive_field(*found, "byteLength");
    if (const Json* attributes = object_field(primitive, "attributes"))
      for (const Json& index : *attributes) bytes += accessor(integer_value(index));
    return bytes + accessor(integer_field(primitive, "indices"));
  }

 private:
  uint64_t accessor(std::optional<int64_t> index) {
    if (!index || !accessors_.insert(*index).second) return 0;
    const Json* found = top_level_object(json_, "accessors", *index);
    return found == nullptr ? 0 : accessor_bytes(*found);
  }

  const Json& json_;
  std::set<int64_t> accessors_, views_;
};

const Json& primitive_of(const Json& json, PrimitiveId id) {
  return json["meshes"][id.mesh]["primitives"][id.primitive];
}

// Calls visit(index) for the accessors of a primitive: attributes, indices and morph targets.
template <typename Visit>
void for_each_accessor(const Json& primitive, Visit&& visit) {
  const auto visit_index = [&](const Json& index) { visit(integer_value(index).value_or(-1)); };
  for_each_member(primitive, "attributes", visit_index);
  if (const Json* indices = field(primitive, "indices")) visit_index(*indices);
  for_each_element(primitive, "targets", [&](const Json& target) {
    if (!target.is_object()) return;
    for (const Json& index : target) visit_index(index);
  });
}

// Calls visit(view) for the buffer views of a primitive's streams.
template <typename Visit>
void for_each_extension_view(const Json& primitive, Visit&& visit) {
  for (const char* name : {kExtensionName, kStockExtensionName})
    if (const Json* extension = extension_field(primitive, name))
      visit(integer_field(*extension, "bufferView").value_or(-1));
}

// Calls visit(view) for every buffer view that has data of a primitive.
template <typename Visit>
void for_each_view(const Json& json, PrimitiveId id, Visit&& visit) {
  const Json& primitive = primitive_of(json, id);
  for_each_extension_view(primitive, visit);
  for_each_accessor(primitive, [&](int64_t index) {
    if (const Json* accessor = top_level_object(json, "accessors", index))
      for_each_buffer_view_member(*accessor,
                                  [&](const Json& view) { visit(integer_value(view).value_or(-1)); });
  });
}

}  // namespace

std::map<std::pair<size_t, size_t>, uint64_t> geometry_bytes(const Document& document) {
  std::map<std::pair<size_t, size_t>, uint64_t> bytes;
  ByteCounter counter(document.json);
  for (const PrimitiveId id : all_primitives(document))
    bytes[{id.mesh, id.primitive}] =
        counter.primitive(document.json["meshes"][id.mesh]["primitives"][id.primitive]);
  return bytes;
}

uint64_t geometry_bytes(const Document& document, std::span<const PrimitiveId> primitives) {
  uint64_t bytes = 0;
  ByteCounter counter(document.json);
  for (const PrimitiveId id : primitives)
    bytes += counter.primitive(document.json["meshes"][id.mesh]["primitives"][id.primitive]);
  return bytes;
}

GeometryOwners::GeometryOwners(const Document& document) : document_(document) {
  for_each_accessor_reference(document.json,
                              [&](const Json& index) { ++accessor_users_[integer_value(index).value_or(-1)]; });
  for_each_buffer_view_reference(document.json,
                                 [&](const Json& index) { ++view_users_[integer_value(index).value_or(-1)]; });
}

std::vector<std::vector<size_t>> GeometryOwners::sharing_sets(const Groups& groups) const {
  std::vector<size_t> parent(groups.size());
  std::iota(parent.begin(), parent.end(), size_t{0});
  const auto root = [&](size_t group) {
    while (parent[group] != group) group = parent[group] = parent[parent[group]];
    return group;
  };
  std::map<int64_t, size_t> first_user;
  for (size_t i = 0; i < groups.size(); ++i)
    for_each_view(document_.json, groups[i]->ids.front(), [&](int64_t view) {
      const size_t other = root(first_user.try_emplace(view, i).first->second), own = root(i);
      parent[std::max(own, other)] = std::min(own, other);
    });
  std::map<size_t, std::vector<size_t>> sets;
  for (size_t i = 0; i < groups.size(); ++i) sets[root(i)].push_back(i);
  std::vector<std::vector<size_t>> result;
  for (auto& [first, set] : sets) result.push_back(std::move(set));
  return result;
}

uint64_t GeometryOwners::bytes_of(const Groups& groups) const {
  const Json& json = document_.json;
  std::map<int64_t, size_t> accessor_uses, view_uses;
  for (const PrimitiveGroup* group : groups) {
    const Json& primitive = primitive_of(json, group->ids.front());
    for_each_accessor(primitive, [&](int64_t index) { accessor_uses[index] += group->ids.size(); });
    for_each_extension_view(primitive, [&](int64_t view) { view_uses[view] += group->ids.size(); });
  }
  const auto is_owned = [](const std::map<int64_t, size_t>& users, int64_t index, size_t uses) {
    const auto found = users.find(index);
    return found != users.end() && found->second == uses;
  };
  const std::map<int64_t, size_t> streams = view_uses;
  std::vector<const Json*> accessors;
  for (const auto& [index, uses] : accessor_uses) {
    const Json* accessor = top_level_object(json, "accessors", index);
    if (accessor == nullptr || !is_owned(accessor_users_, index, uses)) continue;
    accessors.push_back(accessor);
    for_each_buffer_view_member(*accessor,
                                [&](const Json& view) { ++view_uses[integer_value(view).value_or(-1)]; });
  }
  uint64_t bytes = 0;
  for (const Json* accessor : accessors) {
    bool goes = true;
    for_each_buffer_view_member(*accessor, [&](const Json& view) {
      const int64_t index = integer_value(view).value_or(-1);
      goes = goes && is_owned(view_users_, index, view_uses[index]);
    });
    if (goes) bytes += accessor_bytes(*accessor);
  }
  for (const auto& [view, uses] : streams)
    if (is_owned(view_users_, view, view_uses[view]))
      if (const Json* found = top_level_object(json, "bufferViews", view))
        bytes += positive_field(*found, "byteLength");
  return bytes;
}

}  // namespace psplit
