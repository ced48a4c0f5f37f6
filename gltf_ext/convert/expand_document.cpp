#include "gltf_ext/convert/expand_document.h"

#include <algorithm>
#include <map>

#include "gltf_ext/convert/primitive_rules.h"
#include "gltf_ext/convert/replace_streams.h"
#include "gltf_ext/convert/validate.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/primitive/primitive_edit.h"
#include "src/condensed/expand_container.h"
#include "src/cpu/cpu_backend.h"

namespace psplit {
namespace {

// What takes a container's place: another container, or a Draco stream.
struct Expanded {
  std::vector<uint8_t> bytes;  // empty: the container stays
  bool is_draco = false;
  Mesh mesh;  // what the bytes decode to
};

// The primitives whose containers have one buffer view.
struct Users {
  std::vector<PrimitiveId> ids;
  // Whether the mesh may get other points: nothing but the container has data of its points.
  bool allows_other_points = true;
};

// A container that no decoder accepts may have streams that expand.
Expected<Mesh> decode_written(const Expanded& expanded, std::span<const AttributeRequest> requests,
                              const ThreadPool& pool) {
  const Expected<PatchContainer> container =
      expanded.is_draco ? open_stream(expanded.bytes) : open_container(expanded.bytes);
  return container ? cpu_backend().decode(*container, requests, pool) : container.status();
}

Expected<Expanded> expand_bytes(const StoredPrimitive& stored, bool allows_other_points,
                                const ThreadPool& pool) {
  const Expected<PatchContainer> container = open_container(stored.bytes);
  if (!container) return container.status();
  Expanded result;
  if (container->version != kCondensedContainerVersion) return result;
  // Stock Draco repeats points where the stitch map of a single patch joins them.
  result.is_draco = container->entries.size() == 1 && !container->has_residue &&
                    (container->reference_count() == 0 || allows_other_points);
  auto expanded = result.is_draco ? expand_patch(*container, 0) : expand_container(*container, pool);
  if (!expanded) return expanded.status();
  result.bytes = std::move(*expanded);
  Expected<Mesh> mesh = decode_written(result, stored.requests, pool);
  if (!mesh) return mesh.status();
  const bool has_other_points = mesh->point_count != container->point_count();
  if (has_other_points) result.mesh = std::move(*mesh);
  return result;
}

bool has_own_points(const Document& document, PrimitiveId id) {
  const Json& primitive = document.json["meshes"][id.mesh]["primitives"][id.primitive];
  const Json* extension = extension_field(primitive, kExtensionName);
  const Json* stored = extension == nullptr ? nullptr : object_field(*extension, "attributes");
  const Json* attributes = object_field(primitive, "attributes");
  if (stored == nullptr || attributes == nullptr || field(primitive, "targets") != nullptr) return true;
  const auto has_data = [&](const Json& holder, const std::string& name) {
    const auto index = integer_field(holder, name.c_str());
    const Json* accessor = index ? top_level_object(document.json, "accessors", *index) : nullptr;
    return accessor == nullptr || field(*accessor, "bufferView") != nullptr;
  };
  if (has_data(primitive, "indices")) return true;
  return std::ranges::any_of(attributes->items(), [&](const auto& attribute) {
    return field(*stored, attribute.key().c_str()) == nullptr || has_data(*attributes, attribute.key());
  });
}

// By buffer view.
std::map<int64_t, Users> users_of_views(const Document& document) {
  std::map<int64_t, Users> users_of;
  for (const PrimitiveId id : all_primitives(document)) {
    const Json& primitive = document.json["meshes"][id.mesh]["primitives"][id.primitive];
    const Json* extension = extension_field(primitive, kExtensionName);
    if (extension == nullptr) continue;
    Users& users = users_of[integer_field(*extension, "bufferView").value_or(-1)];
    users.ids.push_back(id);
    const PrimitiveId first = users.ids.front();
    const Json& same = document.json["meshes"][first.mesh]["primitives"][first.primitive];
    users.allows_other_points &=
        !has_own_points(document, id) && *extension == *extension_field(same, kExtensionName);
  }
  return users_of;
}

}  // namespace

Expected<ExpandReport> expand_document(Document& document, const ThreadPool& pool) {
  ExpandReport report;
  if (Status status = check_patches(document, cpu_backend(), pool); !status.ok()) return status;
  const std::map<int64_t, Users> users_of = users_of_views(document);
  std::map<int64_t, Expanded> expanded_of;  // by buffer view
  for (const PrimitiveId id : all_primitives(document)) {
    ++report.primitives;
    const Place place{document.source.string(), static_cast<int64_t>(id.mesh),
                      static_cast<int64_t>(id.primitive)};
    const Expected<PrimitiveKind> kind = primitive_kind(document, id);
    if (!kind) return kind.status().at(place);
    if (kind->storage != PrimitiveStorage::kPatches) continue;
    const Expected<StoredPrimitive> stored = stored_primitive(document, id, kExtensionName);
    if (!stored) return stored.status().at(place);
    Json& extensions = *object_field(primitive_json(document, id), "extensions");
    Json& extension = extensions[kExtensionName];
    const auto [found, is_new] = expanded_of.try_emplace(*integer_field(extension, "bufferView"));
    if (is_new) {
      Expected<Expanded> expanded = expand_bytes(*stored, users_of.at(found->first).allows_other_points, pool);
      if (!expanded) return expanded.status().at(place);
      found->second = std::move(*expanded);
      if (!found->second.bytes.empty()) report.bytes_before += stored->bytes.size();
      report.bytes_after += found->second.bytes.size();
    }
    if (found->second.bytes.empty()) continue;
    ++(found->second.is_draco ? report.to_draco : report.to_patches);
    if (!found->second.is_draco) continue;
    list_extension(document, kStockExtensionName, !has_fallback(document, id));
    Json moved = std::move(extension);
    extensions.erase(kExtensionName);
    extensions[kStockExtensionName] = std::move(moved);
  }
  PrimitiveEditor editor(document);
  for (const auto& [view, expanded] : expanded_of)
    if (expanded.mesh.point_count > 0)
      for (const PrimitiveGroup& group : group_equal_primitives(document, users_of.at(view).ids))
        editor.set_geometry(group, expanded.mesh, {}, GeometryData::kStoredElsewhere);
  StreamReplacements replacements;
  for (const auto& [view, expanded] : expanded_of)
    if (!expanded.bytes.empty()) replacements[view] = expanded.bytes;
  replace_streams(document, replacements);
  editor.finish();
  return report;
}

}  // namespace psplit
