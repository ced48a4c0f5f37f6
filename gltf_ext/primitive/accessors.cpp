#include "gltf_ext/primitive/accessors.h"

#include <algorithm>
#include <cstring>

#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

// Elements as a buffer view stores them.
struct StoredElements {
  std::span<const uint8_t> bytes;
  uint64_t stride = 0;
};

Expected<StoredElements> stored_elements(const Document& document, const ElementsRecord& elements,
                                         uint64_t stride) {
  const auto bytes = buffer_view_bytes(document, elements.view);
  if (!bytes) return bytes.status();
  return StoredElements{bytes->subspan(static_cast<size_t>(elements.offset)), stride};
}

Expected<StoredElements> stored_elements(const Document& document, const AccessorRecord& accessor) {
  const uint64_t stated = document.records().view(accessor.elements.view).stride;
  return stored_elements(document, accessor.elements, stated > 0 ? stated : accessor.layout.stored_bytes());
}

// Whether the elements are stored one after the other, as AccessorData has them.
bool is_packed(const ElementLayout& layout, uint64_t stride) {
  return layout.packed_bytes() == layout.stored_bytes() && stride == layout.packed_bytes();
}

void copy_element(const StoredElements& from, uint64_t index, const ElementLayout& layout, std::byte* to) {
  const uint8_t* element = from.bytes.data() + index * from.stride;
  for (size_t column = 0; column < layout.columns; ++column)
    std::memcpy(to + column * layout.column_bytes(), element + column * layout.column_stride(),
                layout.column_bytes());
}

uint32_t index_at(const StoredElements& from, uint64_t index, ComponentType type) {
  uint32_t value = 0;  // little-endian, as glTF and every host of this library
  std::memcpy(&value, from.bytes.data() + index * from.stride, component_bytes(type));
  return value;
}

// `data` holds the elements of the accessor from `first` on.
Status apply_sparse(const Document& document, const AccessorRecord& accessor, uint64_t first,
                    AccessorData& data) {
  const SparseRecord& sparse = *accessor.sparse;
  const ElementLayout& layout = accessor.layout;
  if (sparse.count == 0) return {};
  const auto indices = stored_elements(document, sparse.indices, component_bytes(sparse.index_type));
  if (!indices) return indices.status();
  const auto values = stored_elements(document, sparse.values, layout.stored_bytes());
  if (!values) return values.status();
  for (uint64_t i = 0; i < sparse.count; ++i) {
    const uint32_t index = index_at(*indices, i, sparse.index_type);
    if (index >= accessor.count) return invalid_input("a sparse index past the accessor's end");
    if (index < first || index - first >= data.count) continue;
    copy_element(*values, i, layout, data.values.data() + (index - first) * layout.packed_bytes());
  }
  return {};
}

Expected<AccessorData> read(const Document& document, const AccessorRecord& accessor, uint32_t first,
                            uint32_t count) {
  const ElementLayout& layout = accessor.layout;
  AccessorData data;
  data.component_type = layout.component_type;
  data.component_count = layout.component_count();
  data.normalized = accessor.normalized;
  data.count = std::min(count, accessor.count - first);
  const auto total = static_cast<size_t>(uint64_t{data.count} * layout.packed_bytes());
  if (!accessor.has_view()) {
    if (accessor.packed_bytes() > kMaxUnbackedBytes)
      return invalid_input("more zeros without a buffer view than are allowed");
    data.values.assign(total, std::byte{0});
  } else {
    const auto elements = stored_elements(document, accessor);
    if (!elements) return elements.status();
    data.values.resize(total);
    if (is_packed(layout, elements->stride) && total > 0)
      std::memcpy(data.values.data(), elements->bytes.data() + first * elements->stride, total);
    else
      for (uint64_t i = 0; i < data.count; ++i)
        copy_element(*elements, first + i, layout, data.values.data() + i * layout.packed_bytes());
  }
  if (accessor.sparse)
    if (Status status = apply_sparse(document, accessor, first, data); !status.ok()) return status;
  return data;
}

void set_bounds(Json& accessor, const ValuesView& data) {
  ValueBounds bounds;
  for_each_step(data, [&](size_t first, size_t end) {
    bounds.add(data.component_type, data.component_count, data.at(first), end - first, data.step());
    return true;
  });
  bounds.finish();
  accessor["min"] = bound_json(bounds.least, data.component_type);
  accessor["max"] = bound_json(bounds.most, data.component_type);
}

// Vertex attributes start on 4-byte boundaries.
size_t stride_in_view(const ElementLayout& layout, int target) {
  return target == kArrayBuffer ? (layout.stored_bytes() + 3) / 4 * 4 : layout.stored_bytes();
}

void store_element(const ValuesView& data, size_t index, const ElementLayout& layout, uint8_t* to) {
  for (size_t column = 0; column < layout.columns; ++column)
    std::memcpy(to + column * layout.column_stride(), data.at(index) + column * layout.column_bytes(),
                layout.column_bytes());
}

// -0 is zero, too, unless its sign counts.
bool is_zero(const ValuesView& data, size_t index, size_t element_bytes, ZeroSign sign) {
  const std::span<const std::byte> element(data.at(index), element_bytes);
  constexpr std::byte kSign{0x80};
  const bool has_signs = data.component_type == ComponentType::kFloat32 && sign == ZeroSign::kIgnored;
  for (size_t i = 0; i < element.size(); ++i) {
    const bool is_negative_zero = has_signs && i % sizeof(float) == sizeof(float) - 1 && element[i] == kSign;
    if (element[i] != std::byte{0} && !is_negative_zero) return false;
  }
  return true;
}

// Makes `accessor` refer to a new view.
void describe_view(Document& document, Json& accessor, const ElementLayout& layout, int target,
                   int64_t view_index) {
  Json& view = document.json()["bufferViews"][static_cast<size_t>(view_index)];
  const size_t stride = stride_in_view(layout, target);
  if (stride != layout.stored_bytes()) view["byteStride"] = stride;
  if (target != 0) view["target"] = target;
  accessor["bufferView"] = view_index;
}

}  // namespace

Expected<AccessorData> read_accessor(const Document& document, int64_t index) {
  return read_accessor(document, index, 0, UINT32_MAX);
}

Expected<AccessorData> read_accessor(const Document& document, int64_t index, uint32_t first, uint32_t count) {
  auto data = read(document, document.records().accessor(index), first, count);
  if (!data)
    return Status(data.status().code(), "accessor " + std::to_string(index) + ": " + data.status().message());
  return data;
}

Expected<ValuesView> accessor_view(const Document& document, int64_t index) {
  const AccessorRecord& accessor = document.records().accessor(index);
  const ElementLayout& layout = accessor.layout;
  if (accessor.sparse || !accessor.has_view() || layout.packed_bytes() != layout.stored_bytes())
    return unsupported("accessor " + std::to_string(index) + " does not store its values as they are");
  const auto elements = stored_elements(document, accessor);
  if (!elements) return elements.status();
  return ValuesView{
      layout.component_type, layout.component_count(),       accessor.normalized,
      accessor.count,        std::as_bytes(elements->bytes), static_cast<size_t>(elements->stride)};
}

Json describe_stored(const ValuesView& data) {
  const std::optional<ElementLayout> layout = layout_of(data);
  if (!layout) return Json::object();
  Json accessor = {{"componentType", static_cast<int>(data.component_type)}, {"count", data.count}};
  if (data.normalized) accessor["normalized"] = true;
  accessor["type"] = type_name(*layout);
  return accessor;
}

void write_values(const ValuesView& data, int target, uint8_t* to) {
  const std::optional<ElementLayout> layout = layout_of(data);
  if (!layout) return;
  const size_t stride = stride_in_view(*layout, target);
  if (is_packed(*layout, stride) && data.step() == stride && data.count > 0)
    std::memcpy(to, data.at(0), data.count * stride);
  else
    for (size_t i = 0; i < data.count; ++i) store_element(data, i, *layout, to + i * stride);
}

void store_values(Document& document, Json& accessor, const ValuesView& data, int target,
                  std::shared_ptr<const void> owner) {
  const std::optional<ElementLayout> layout = layout_of(data);
  if (!layout) return;  // no glTF type has this number of components
  const size_t stride = stride_in_view(*layout, target);
  Span<const uint8_t> bytes(reinterpret_cast<const uint8_t*>(data.bytes.data()), data.count * stride);
  std::vector<uint8_t> stored;
  if (!is_packed(*layout, stride) || data.step() != stride) {
    stored.resize(data.count * stride);
    write_values(data, target, stored.data());
    bytes = stored;
  } else if (owner != nullptr && bytes.size() >= kLargeBuffer) {
    const size_t buffer = append_buffer(document, Buffer(bytes, std::move(owner)));
    return place_values(document, accessor, data, target, buffer, 0);
  }
  describe_view(document, accessor, *layout, target, append_buffer_view(document, bytes));
}

void place_values(Document& document, Json& accessor, const ValuesView& data, int target, size_t buffer,
                  uint64_t offset) {
  const std::optional<ElementLayout> layout = layout_of(data);
  if (!layout) return;
  Json& views = document.json()["bufferViews"];
  views.push_back({{"buffer", buffer}, {"byteOffset", offset}, {"byteLength", data.count * data.step()}});
  describe_view(document, accessor, *layout, target, static_cast<int64_t>(views.size() - 1));
}

size_t stored_stride(const ValuesView& data, int target) {
  const std::optional<ElementLayout> layout = layout_of(data);
  return layout ? stride_in_view(*layout, target) : 0;
}

std::vector<uint32_t> elements_that_are_not_zero(const ValuesView& data, ZeroSign sign) {
  std::vector<uint32_t> kept;
  const std::optional<ElementLayout> layout = layout_of(data);
  if (!layout) return kept;
  for (uint32_t i = 0; i < data.count; ++i)
    if (!is_zero(data, i, layout->packed_bytes(), sign)) kept.push_back(i);
  return kept;
}

namespace {

ComponentType sparse_index_type(std::span<const uint32_t> kept) {
  const uint32_t last = kept.empty() ? 0 : kept.back();
  return last <= 0xff     ? ComponentType::kUint8
         : last <= 0xffff ? ComponentType::kUint16
                          : ComponentType::kUint32;
}

}  // namespace

uint64_t sparse_bytes(const ValuesView& data, std::span<const uint32_t> kept) {
  const std::optional<ElementLayout> layout = layout_of(data);
  return layout ? kept.size() * (component_bytes(sparse_index_type(kept)) + layout->stored_bytes()) : 0;
}

SparseData sparse_data(const ValuesView& data, std::span<const uint32_t> kept) {
  SparseData sparse{sparse_index_type(kept), {}, {}};
  const std::optional<ElementLayout> layout = layout_of(data);
  if (!layout) return sparse;
  const size_t index_bytes = component_bytes(sparse.index_type), value_bytes = layout->stored_bytes();
  sparse.indices.resize(kept.size() * index_bytes);
  sparse.values.resize(kept.size() * value_bytes);
  for (size_t i = 0; i < kept.size(); ++i) {
    std::memcpy(sparse.indices.data() + i * index_bytes, &kept[i], index_bytes);  // little-endian
    store_element(data, kept[i], *layout, sparse.values.data() + i * value_bytes);
  }
  return sparse;
}

void store_values_sparse(Document& document, Json& accessor, const ValuesView& data, int target) {
  const std::vector<uint32_t> kept = elements_that_are_not_zero(data, ZeroSign::kKept);
  if (kept.empty()) return;  // an accessor without a view is zero
  if (sparse_bytes(data, kept) >= data.count * stored_stride(data, target))
    return store_values(document, accessor, data, target);
  const SparseData sparse = sparse_data(data, kept);
  const int64_t index_view = append_buffer_view(document, sparse.indices);
  const int64_t value_view = append_buffer_view(document, sparse.values);
  accessor["sparse"] = {
      {"count", kept.size()},
      {"indices", {{"bufferView", index_view}, {"componentType", static_cast<int>(sparse.index_type)}}},
      {"values", {{"bufferView", value_view}}}};
}

int64_t append_accessor(Document& document, const ValuesView& data, int target, bool with_bounds,
                        std::shared_ptr<const void> owner) {
  Json accessor = describe_stored(data);
  if (accessor.empty()) return -1;
  store_values(document, accessor, data, target, std::move(owner));
  if (with_bounds && data.count > 0) set_bounds(accessor, data);
  Json& accessors = document.json()["accessors"];
  if (!accessors.is_array()) accessors = Json::array();
  accessors.push_back(std::move(accessor));
  return static_cast<int64_t>(accessors.size() - 1);
}

bool is_bound(const Json* stated, const Json& exact) {
  if (stated == nullptr || !stated->is_array() || stated->size() != exact.size()) return false;
  for (size_t c = 0; c < exact.size(); ++c) {
    const auto a = number_value((*stated)[c]), b = number_value(exact[c]);
    if (!a || !b || static_cast<float>(*a) != static_cast<float>(*b)) return false;
  }
  return true;
}

void describe_decoded(Json& accessor, const ValuesView& data, bool with_bounds) {
  for (const char* name : {"bufferView", "byteOffset", "sparse"}) accessor.erase(name);
  accessor["count"] = data.count;
  if (with_bounds && data.count > 0) {
    set_bounds(accessor, data);
  } else {
    for (const char* name : {"min", "max"}) accessor.erase(name);  // they described other values
  }
}

}  // namespace psplit
