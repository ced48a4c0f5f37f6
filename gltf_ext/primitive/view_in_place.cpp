#include "gltf_ext/primitive/view_in_place.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <vector>

namespace psplit {
namespace {

Expected<ValuesView> values_in_place(const Document& document, const std::string& name, int64_t index) {
  const AccessorRecord& accessor = document.records().accessor(index);
  if (accessor.sparse || !accessor.has_view())
    return unsupported(name + ": a sparse accessor does not fit into --memory");
  if (accessor.layout.stored_bytes() != accessor.layout.packed_bytes())
    return unsupported(name + ": a matrix with padding does not fit into --memory");
  return accessor_view(document, index);
}

Expected<ValuesView> indices_in_place(const Document& document, int64_t accessor, uint32_t point_count) {
  Expected<ValuesView> indices = ValuesView{ComponentType::kUint32, 1, false, point_count, {}};
  if (accessor >= 0) indices = values_in_place(document, "indices", accessor);
  if (!indices) return indices;
  const ComponentType type = indices->component_type;
  if (indices->component_count != 1 ||
      (type != ComponentType::kUint8 && type != ComponentType::kUint16 && type != ComponentType::kUint32))
    return invalid_input("indices are not unsigned scalars");
  if (indices->count % 3 != 0)
    return invalid_input("a triangle list has " + std::to_string(indices->count) + " indices");
  return indices;
}

}  // namespace

Expected<MeshView> view_in_place(const Document& document, PrimitiveId id) {
  const PrimitiveRecord& primitive = document.records().primitive(id);
  if (!primitive.status.ok()) return primitive.status;
  if (primitive.storage() != PrimitiveStorage::kPlain)
    return unsupported("a compressed primitive does not fit into --memory");
  if (primitive.mode != 4) return unsupported("a triangle strip or fan does not fit into --memory");
  if (primitive.accessor_of("POSITION") < 0) return unsupported("no POSITION");
  MeshView view;
  for (const auto& [semantic, accessor] : primitive.attributes) {
    const Expected<ValuesView> values = values_in_place(document, "attribute " + semantic, accessor);
    if (!values) return values.status();
    if (!view.attributes.empty() && values->count != view.point_count)
      return invalid_input("attribute " + semantic + " has " + std::to_string(values->count) +
                           " elements, others have " + std::to_string(view.point_count));
    view.point_count = values->count;
    view.attributes.push_back({semantic, *values});
  }
  const Expected<ValuesView> indices = indices_in_place(document, primitive.indices, view.point_count);
  if (!indices) return indices.status();
  view.indices = *indices;
  return view;
}

std::optional<MeshView> valid_view_in_place(const Document& document, PrimitiveId id) {
  const Expected<MeshView> view = view_in_place(document, id);
  if (!view) return std::nullopt;
  constexpr size_t kAtOnce = 4096;
  std::vector<uint32_t> read(kAtOnce);
  const bool are_valid = for_each_step(view->indices, [&](size_t first, size_t end) {
    for (; first < end; first += std::min(kAtOnce, end - first)) {
      const std::span<uint32_t> to = std::span(read).first(std::min(kAtOnce, end - first));
      if (!read_indices(view->indices, first, view->point_count, to).ok()) return false;
    }
    return true;
  });
  return are_valid ? std::optional(*view) : std::nullopt;
}

Status read_indices(const ValuesView& indices, size_t first, uint32_t point_count, std::span<uint32_t> to) {
  if (indices.bytes.empty()) {
    std::iota(to.begin(), to.end(), static_cast<uint32_t>(first));
    return {};
  }
  const size_t width = indices.value_bytes();
  const uint32_t restart = width == 4 ? UINT32_MAX : (1u << 8 * width) - 1;
  if (width == sizeof(uint32_t) && indices.step() == width && !to.empty()) {
    std::memcpy(to.data(), indices.at(first), to.size_bytes());
    // If any is wrong, the loop tells which.
    uint32_t largest = 0;
    for (const uint32_t index : to) largest = std::max(largest, index);
    if (largest < point_count && largest != restart) return {};
  }
  for (size_t i = 0; i < to.size(); ++i) {
    to[i] = 0;
    std::memcpy(&to[i], indices.at(first + i), width);  // little-endian, as glTF
    if (to[i] == restart)
      return invalid_input("index " + std::to_string(first + i) + " is " + std::to_string(restart) +
                           ", which restarts primitives and glTF forbids");
    if (to[i] >= point_count)
      return invalid_input("index " + std::to_string(first + i) + " is " + std::to_string(to[i]) +
                           ", but there are " + std::to_string(point_count) + " points");
  }
  return {};
}

}  // namespace psplit
