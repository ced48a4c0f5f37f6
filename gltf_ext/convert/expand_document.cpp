#include "gltf_ext/convert/expand_document.h"

#include <map>

#include "gltf_ext/convert/primitive_rules.h"
#include "gltf_ext/document/drop_unused.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/primitive/primitive_edit.h"
#include "src/condensed/expand_container.h"

namespace psplit {
namespace {

// What takes a container's place: another container, or a Draco stream.
struct Expanded {
  int64_t buffer_view = -1;  // -1: the container stays
  bool is_draco = false;
};

Expected<Expanded> expand_bytes(Document& document, std::span<const uint8_t> bytes, const ThreadPool& pool,
                                ExpandReport& report) {
  const Expected<PatchContainer> container = open_container(bytes);
  if (!container) return container.status();
  if (container->version != kCondensedContainerVersion) return Expanded();
  const bool is_draco =
      container->entries.size() == 1 && !container->has_residue && container->reference_count() == 0;
  const auto expanded = is_draco ? expand_patch(*container, 0) : expand_container(*container, pool);
  if (!expanded) return expanded.status();
  report.bytes_before += bytes.size();
  report.bytes_after += expanded->size();
  return Expanded{append_buffer_view(document, *expanded), is_draco};
}

}  // namespace

Expected<ExpandReport> expand_document(Document& document, const ThreadPool& pool) {
  ExpandReport report;
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
      const Expected<Expanded> expanded = expand_bytes(document, stored->bytes, pool, report);
      if (!expanded) return expanded.status().at(place);
      found->second = *expanded;
    }
    if (found->second.buffer_view < 0) continue;
    extension["bufferView"] = found->second.buffer_view;
    ++(found->second.is_draco ? report.to_draco : report.to_patches);
    if (!found->second.is_draco) continue;
    list_extension(document, kStockExtensionName, !has_fallback(document, id));
    Json moved = std::move(extension);
    extensions.erase(kExtensionName);
    extensions[kStockExtensionName] = std::move(moved);
  }
  drop_unused(document, {});
  unlist_unused_extension(document, kExtensionName);
  return report;
}

}  // namespace psplit
