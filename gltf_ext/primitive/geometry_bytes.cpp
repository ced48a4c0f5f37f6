#include "gltf_ext/primitive/geometry_bytes.h"

#include <algorithm>
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

std::optional<uint64_t> GeometryOwners::bytes_of(const PrimitiveGroup& group) const {
  const Json& json = document_.json;
  const PrimitiveId first = group.ids.front();
  const Json& primitive = json["meshes"][first.mesh]["primitives"][first.primitive];
  std::map<int64_t, size_t> accessor_uses, view_uses;
  if (const Json* attributes = object_field(primitive, "attributes"))
    for (const Json& index : *attributes) accessor_uses[integer_value(index).value_or(-1)] += group.ids.size();
  if (const auto indices = integer_field(primitive, "indices")) accessor_uses[*indices] += group.ids.size();
  for (const char* name : {kExtensionName, kStockExtensionName})
    if (const Json* extension = extension_field(primitive, name))
      view_uses[integer_field(*extension, "bufferView").value_or(-1)] += group.ids.size();
  const auto has_others = [](const auto& uses, const auto& users) {
    return std::any_of(uses.begin(), uses.end(), [&](const auto& use) {
      const auto found = users.find(use.first);
      return found == users.end() || found->second != use.second;
    });
  };
  for (auto use = accessor_uses.begin(); use != accessor_uses.end();) {
    std::map<int64_t, size_t> views;
    if (const Json* accessor = top_level_object(json, "accessors", use->first))
      for_each_buffer_view_member(*accessor,
                                  [&](const Json& index) { ++views[integer_value(index).value_or(-1)]; });
    for (const auto& [view, count] : views) view_uses[view] += count;
    // Other objects may share an accessor without data.
    use = views.empty() ? accessor_uses.erase(use) : std::next(use);
  }
  if (has_others(accessor_uses, accessor_users_) || has_others(view_uses, view_users_)) return std::nullopt;
  return ByteCounter(json).primitive(primitive);
}

}  // namespace psplit
