#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "encoder/fields/expand_container.h"
#include "gltf_ext/convert/replace_streams.h"
#include "gltf_ext/convert/validate.h"
#include "gltf_ext/document/unknown_references.h"
#include "gltf_ext/primitive/primitive_edit.h"
#include "psplit/decode.h"
#include "psplit/gltf.h"

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

// Stock Draco has no names for morph targets.
bool has_targets(const StoredPrimitive& stored) {
  return std::ranges::any_of(
      stored.requests, [](const AttributeRequest& request) { return target_of(request.semantic).has_value(); });
}

Expected<Expanded> expand_bytes(const StoredPrimitive& stored, bool allows_other_points,
                                const ThreadPool& pool) {
  const Expected<PatchContainer> container = open_container(stored.bytes);
  if (!container) return container.status();
  Expanded result;
  if (container->condensed_count() == 0) return result;
  // Stock Draco repeats points where the stitch map of a single patch joins them.
  result.is_draco = container->entries.size() == 1 && !container->has_residue && !has_targets(stored) &&
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

bool has_own_points(const AssetRecords& records, const PrimitiveRecord& primitive) {
  const auto has_data = [&](int64_t accessor) { return accessor < 0 || records.accessor(accessor).has_view(); };
  const auto is_elsewhere = [&](size_t target) {
    return std::ranges::any_of(primitive.targets[target], [&](const AttributeRecord& deltas) {
      return !primitive.patches->stores(name_of_target(target, deltas.semantic)) || has_data(deltas.accessor);
    });
  };
  bool has_other_targets = false;
  for (size_t t = 0; t < primitive.targets.size(); ++t) has_other_targets |= is_elsewhere(t);
  return has_other_targets || has_data(primitive.indices) ||
         std::ranges::any_of(primitive.attributes, [&](const AttributeRecord& attribute) {
           return !primitive.patches->stores(attribute.semantic) || has_data(attribute.accessor);
         });
}

bool stores_same(const DracoRecord& a, const DracoRecord& b) {
  const auto is_same = [](const AttributeRequest& left, const AttributeRequest& right) {
    return left.semantic == right.semantic && left.unique_id == right.unique_id;
  };
  return std::ranges::equal(a.requests, b.requests, is_same);
}

// The old bytes stay in their view.
void move_to_own_view(Document& document, std::span<const PrimitiveId> ids, const Expanded& expanded) {
  const int64_t view = append_buffer_view(document, expanded.bytes);
  for (const PrimitiveId id : ids)
    primitive_json(document,
                   id)["extensions"][expanded.is_draco ? kStockExtensionName : kExtensionName]["bufferView"] =
        view;
}

// The users of each buffer view.
std::map<int64_t, Users> users_of_views(const Document& document) {
  const AssetRecords& records = document.records();
  std::map<int64_t, Users> users_of;
  for (const PrimitiveId id : all_primitives(document)) {
    const PrimitiveRecord& primitive = records.primitive(id);
    if (!primitive.patches) continue;
    Users& users = users_of[primitive.patches->view];
    users.ids.push_back(id);
    const PrimitiveRecord& first = records.primitive(users.ids.front());
    users.allows_other_points &=
        !has_own_points(records, primitive) && stores_same(*primitive.patches, *first.patches);
  }
  return users_of;
}

}  // namespace

Expected<ExpandReport> expand_document(Document& document, const DecodeBackend& backend,
                                       const ThreadPool& pool) {
  ExpandReport report;
  if (Status status = document.check(); !status.ok()) return status;
  if (Status status = check_document(document, backend, pool); !status.ok()) return status;
  const std::map<int64_t, Users> users_of = users_of_views(document);
  std::map<int64_t, Expanded> expanded_of;  // by buffer view
  std::vector<PrimitiveId> become_draco;
  for (const PrimitiveId id : all_primitives(document)) {
    ++report.primitives;
    const Place place = place_of(document, id);
    const PrimitiveRecord& primitive = document.records().primitive(id);
    if (!primitive.status.ok()) return Status(primitive.status).at(place);
    if (primitive.storage() != PrimitiveStorage::kPatches) continue;
    const Expected<StoredPrimitive> stored = stored_primitive(document, id);
    if (!stored) return stored.status().at(place);
    const auto [found, is_new] = expanded_of.try_emplace(primitive.patches->view);
    if (is_new) {
      Expected<Expanded> expanded = expand_bytes(*stored, users_of.at(found->first).allows_other_points, pool);
      if (!expanded) return expanded.status().at(place);
      found->second = std::move(*expanded);
      if (!found->second.bytes.empty()) report.bytes_before += stored->bytes.size();
      report.bytes_after += found->second.bytes.size();
    }
    if (found->second.bytes.empty()) continue;
    ++(found->second.is_draco ? report.to_draco : report.to_patches);
    if (found->second.is_draco) become_draco.push_back(id);
  }
  rename_draco_extension(document, become_draco, kExtensionName, kStockExtensionName);
  // Groups are of the records before any edit.
  std::vector<std::pair<const Mesh*, std::vector<PrimitiveGroup>>> edits;
  for (const auto& [view, expanded] : expanded_of)
    if (expanded.mesh.point_count > 0)
      edits.emplace_back(&expanded.mesh, group_equal_primitives(document, users_of.at(view).ids));
  PrimitiveEditor editor(document);
  for (const auto& [mesh, groups] : edits)
    for (const PrimitiveGroup& group : groups)
      editor.set_geometry(group, *mesh, {}, GeometryData::kStoredElsewhere);
  // What unknown data may name keeps its bytes.
  const std::set<int64_t> named = find_unknown_references(std::as_const(document).json()).views;
  StreamReplacements replacements;
  for (const auto& [view, expanded] : expanded_of) {
    if (expanded.bytes.empty()) continue;
    if (named.contains(view))
      move_to_own_view(document, users_of.at(view).ids, expanded);
    else
      replacements[view] = expanded.bytes;
  }
  replace_streams(document, replacements);
  editor.finish();
  return report;
}

}  // namespace psplit
