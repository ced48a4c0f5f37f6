#include "gltf_ext/primitive/view_in_place.h"

#include <algorithm>
#include <cstring>

namespace psplit {

std::optional<MeshView> view_in_place(const Document& document, PrimitiveId id) {
  const PrimitiveRecord& primitive = document.records().primitive(id);
  if (primitive.storage() != PrimitiveStorage::kPlain || primitive.accessor_of("POSITION") < 0 ||
      primitive.indices < 0 || primitive.mode != 4)
    return std::nullopt;
  MeshView view;
  for (const auto& [semantic, accessor] : primitive.attributes) {
    const Expected<ValuesView> values = accessor_view(document, accessor);
    if (!values) return std::nullopt;
    view.point_count = values->count;
    view.attributes.push_back({semantic, *values});
  }
  const Expected<ValuesView> values = accessor_view(document, primitive.indices);
  const bool is_same_count = std::ranges::all_of(
      view.attributes, [&](const auto& found) { return found.values.count == view.point_count; });
  if (!values || !is_same_count || values->component_count != 1 || values->count % 3 != 0) return std::nullopt;
  const ComponentType type = values->component_type;
  if (type != ComponentType::kUint8 && type != ComponentType::kUint16 && type != ComponentType::kUint32)
    return std::nullopt;
  view.indices = *values;
  return view;
}

bool has_valid_indices(const MeshView& view) {
  const size_t width = view.indices.value_bytes();
  const uint32_t restart = width == 4 ? UINT32_MAX : (1u << 8 * width) - 1;
  return for_each_step(view.indices, [&](size_t first, size_t end) {
    for (size_t i = first; i < end; ++i) {
      uint32_t index = 0;  // little-endian, as glTF
      std::memcpy(&index, view.indices.at(i), width);
      if (index == restart || index >= view.point_count) return false;
    }
    return true;
  });
}

}  // namespace psplit
