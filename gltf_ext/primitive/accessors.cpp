#include "gltf_ext/primitive/accessors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "gltf_ext/document/element_layout.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

// Elements as a buffer view stores them.
struct StoredElements {
  std::span<const uint8_t> bytes;
  uint64_t stride = 0;
};

Expected<StoredElements> stored_elements(const Document& document, const Json& part,
                                         const ElementLayout& layout, uint64_t count, bool strided) {
  const auto view_index = integer_field(part, "bufferView");
  const auto offset = integer_field_or(part, "byteOffset", 0);
  if (!view_index || !offset || *offset < 0) return invalid_input("no valid bufferView or byteOffset");
  const auto bytes = buffer_view_bytes(document, *view_index);
  if (!bytes) return bytes.status();
  const Json* view = top_level_object(document.json, "bufferViews", *view_index);
  const auto stated = strided ? integer_field_or(*view, "byteStride", 0) : 0;
  if (!stated || *stated < 0) return invalid_input("an invalid byteStride");
  const uint64_t stride = *stated == 0 ? layout.stored_bytes() : static_cast<uint64_t>(*stated);
  if (stride < layout.last_bytes()) return invalid_input("elements are longer than the stride");
  const auto start = static_cast<uint64_t>(*offset);
  if (!elements_fit(layout, start, stride, count, bytes->size()))
    return invalid_input("elements reach past the buffer view");
  return StoredElements{bytes->subspan(static_cast<size_t>(start)), stride};
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

// Elements [first, first + count) of an accessor.
struct ElementRange {
  uint64_t first = 0, count = UINT64_MAX;
};

// `data` holds the elements of `wanted` of an accessor with `whole_count` elements.
Status apply_sparse(const Document& document, const Json& sparse, const ElementLayout& layout,
                    uint64_t whole_count, ElementRange wanted, AccessorData& data) {
  const auto count = integer_field(sparse, "count");
  const Json* indices = object_field(sparse, "indices");
  const Json* values = object_field(sparse, "values");
  if (!count || *count < 0 || static_cast<uint64_t>(*count) > whole_count || indices == nullptr ||
      values == nullptr)
    return invalid_input("sparse without a valid count, indices or values");
  const auto component = integer_field(*indices, "componentType");
  if (!component || (*component != 5121 && *component != 5123 && *component != 5125))
    return invalid_input("sparse with an invalid index type");
  const ElementLayout index_layout{.component_type = static_cast<ComponentType>(*component)};
  const auto sparse_count = static_cast<uint64_t>(*count);
  if (sparse_count == 0) return {};
  const auto from_indices = stored_elements(document, *indices, index_layout, sparse_count, false);
  if (!from_indices) return from_indices.status();
  const auto from_values = stored_elements(document, *values, layout, sparse_count, false);
  if (!from_values) return from_values.status();
  for (uint64_t i = 0; i < sparse_count; ++i) {
    const uint32_t index = index_at(*from_indices, i, index_layout.component_type);
    if (index >= whole_count) return invalid_input("a sparse index past the accessor's end");
    if (index < wanted.first || index - wanted.first >= data.count) continue;
    copy_element(*from_values, i, layout, data.values.data() + (index - wanted.first) * layout.packed_bytes());
  }
  return {};
}

Expected<AccessorData> read(const Document& document, const Json& accessor, ElementRange wanted) {
  const auto layout = element_layout(accessor);
  if (!layout) return layout.status();
  const auto count = integer_field(accessor, "count");
  if (!count || *count < 0 || *count > std::numeric_limits<uint32_t>::max())
    return invalid_input("no valid count");

  AccessorData data;
  data.component_type = layout->component_type;
  data.component_count = layout->component_count();
  data.normalized = bool_field_or(accessor, "normalized", false);
  const auto whole_count = static_cast<uint64_t>(*count);
  data.count = static_cast<uint32_t>(std::min(wanted.count, whole_count - wanted.first));
  const uint64_t total = uint64_t{data.count} * layout->packed_bytes();
  if (field(accessor, "bufferView") == nullptr) {
    if (whole_count * layout->packed_bytes() > kMaxUnbackedBytes)
      return invalid_input("more zeros without a buffer view than are allowed");
    data.values.assign(static_cast<size_t>(total), std::byte{0});
  } else {
    const auto elements = stored_elements(document, accessor, *layout, whole_count, true);
    if (!elements) return elements.status();
    data.values.resize(static_cast<size_t>(total));
    for (uint64_t i = 0; i < data.count; ++i)
      copy_element(*elements, wanted.first + i, *layout, data.values.data() + i * layout->packed_bytes());
  }
  if (const Json* sparse = field(accessor, "sparse"))
    if (Status status = apply_sparse(document, *sparse, *layout, whole_count, wanted, data); !status.ok())
      return status;
  return data;
}

const char* type_name(uint8_t component_count) {
  switch (component_count) {
    case 1: return "SCALAR";
    case 2: return "VEC2";
    case 3: return "VEC3";
    case 4: return "VEC4";
    case 9: return "MAT3";
    case 16: return "MAT4";
    default: return nullptr;
  }
}

template <typename T>
void bounds_of(const ValuesView& data, Json& least, Json& most) {
  constexpr size_t kMostComponents = 16;
  const size_t components = std::min<size_t>(data.component_count, kMostComponents);
  std::array<T, kMostComponents> low, high;
  low.fill(std::numeric_limits<T>::max());
  high.fill(std::numeric_limits<T>::lowest());
  for_each_step(data, [&](size_t first, size_t end) {
    for (size_t i = first; i < end; ++i)
      for (size_t component = 0; component < components; ++component) {
        T value;
        std::memcpy(&value, data.at(i) + component * sizeof(T), sizeof(T));
        if constexpr (std::is_floating_point_v<T>)
          if (!std::isfinite(value)) continue;  // JSON cannot express it
        low[component] = std::min(low[component], value);
        high[component] = std::max(high[component], value);
      }
    return true;
  });
  for (size_t component = 0; component < components; ++component) {
    const bool is_finite = low[component] <= high[component];
    least.push_back(is_finite ? low[component] : T{});
    most.push_back(is_finite ? high[component] : T{});
  }
}

void set_bounds(Json& accessor, const ValuesView& data) {
  Json least = Json::array(), most = Json::array();
  switch (data.component_type) {
    case ComponentType::kInt8: bounds_of<int8_t>(data, least, most); break;
    case ComponentType::kUint8: bounds_of<uint8_t>(data, least, most); break;
    case ComponentType::kInt16: bounds_of<int16_t>(data, least, most); break;
    case ComponentType::kUint16: bounds_of<uint16_t>(data, least, most); break;
    case ComponentType::kUint32: bounds_of<uint32_t>(data, least, most); break;
    case ComponentType::kFloat32: bounds_of<float>(data, least, most); break;
  }
  accessor["min"] = std::move(least);
  accessor["max"] = std::move(most);
}

// Vertex attributes start on 4-byte boundaries.
size_t stride_in_view(const ElementLayout& layout, int target) {
  constexpr int kArrayBuffer = 34962;
  return target == kArrayBuffer ? (layout.stored_bytes() + 3) / 4 * 4 : layout.stored_bytes();
}

void store_element(const ValuesView& data, size_t index, const ElementLayout& layout, uint8_t* to) {
  for (size_t column = 0; column < layout.columns; ++column)
    std::memcpy(to + column * layout.column_stride(), data.at(index) + column * layout.column_bytes(),
                layout.column_bytes());
}

bool is_zero(const ValuesView& data, size_t index, size_t element_bytes) {
  const std::byte* element = data.at(index);
  return std::all_of(element, element + element_bytes, [](std::byte b) { return b == std::byte{0}; });
}

// Makes `accessor` refer to a new view.
void describe_view(Document& document, Json& accessor, const ElementLayout& layout, int target,
                   int64_t view_index) {
  Json& view = document.json["bufferViews"][static_cast<size_t>(view_index)];
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
  const std::string name = "accessor " + std::to_string(index);
  const Json* accessor = top_level_object(document.json, "accessors", index);
  if (accessor == nullptr) return invalid_input(name + " does not exist");
  auto data = read(document, *accessor, {first, count});
  if (!data) return Status(data.status().code(), name + ": " + data.status().message());
  return data;
}

Expected<ValuesView> accessor_view(const Document& document, int64_t index) {
  const auto none = read_accessor(document, index, 0, 0);  // checks everything
  if (!none) return none.status();
  const Json& accessor = *top_level_object(document.json, "accessors", index);
  const ElementLayout layout = *element_layout(accessor);
  if (field(accessor, "sparse") != nullptr || field(accessor, "bufferView") == nullptr ||
      layout.packed_bytes() != layout.stored_bytes())
    return unsupported("accessor " + std::to_string(index) + " does not store its values as they are");
  const auto count = static_cast<uint32_t>(*integer_field(accessor, "count"));
  const auto elements = stored_elements(document, accessor, layout, count, true);
  if (!elements) return elements.status();
  return ValuesView{none->component_type,
                    none->component_count,
                    none->normalized,
                    count,
                    std::as_bytes(elements->bytes),
                    static_cast<size_t>(elements->stride)};
}

Json describe_stored(const ValuesView& data) {
  const char* type = type_name(data.component_count);
  if (type == nullptr) return Json::object();
  Json accessor = {{"componentType", static_cast<int>(data.component_type)}, {"count", data.count}};
  if (data.normalized) accessor["normalized"] = true;
  accessor["type"] = type;
  return accessor;
}

void write_values(const ValuesView& data, int target, uint8_t* to) {
  const Expected<ElementLayout> layout = element_layout(describe_stored(data));
  if (!layout) return;
  const size_t stride = stride_in_view(*layout, target);
  for (size_t i = 0; i < data.count; ++i) store_element(data, i, *layout, to + i * stride);
}

void store_values(Document& document, Json& accessor, const ValuesView& data, int target) {
  const Expected<ElementLayout> layout = element_layout(describe_stored(data));
  if (!layout) return;  // no glTF type has this number of components
  std::vector<uint8_t> stored(data.count * stride_in_view(*layout, target));
  write_values(data, target, stored.data());
  describe_view(document, accessor, *layout, target, append_buffer_view(document, stored));
}

void place_values(Document& document, Json& accessor, const ValuesView& data, int target, size_t buffer,
                  uint64_t offset) {
  const Expected<ElementLayout> layout = element_layout(describe_stored(data));
  if (!layout) return;
  Json& views = document.json["bufferViews"];
  views.push_back({{"buffer", buffer}, {"byteOffset", offset}, {"byteLength", data.count * data.step()}});
  describe_view(document, accessor, *layout, target, static_cast<int64_t>(views.size() - 1));
}

size_t stored_stride(const ValuesView& data, int target) {
  const Expected<ElementLayout> layout = element_layout(describe_stored(data));
  return layout ? stride_in_view(*layout, target) : 0;
}

void store_values_sparse(Document& document, Json& accessor, const ValuesView& data, int target) {
  const Expected<ElementLayout> layout = element_layout(describe_stored(data));
  if (!layout) return;
  std::vector<uint32_t> kept;
  for (uint32_t i = 0; i < data.count; ++i)
    if (!is_zero(data, i, layout->packed_bytes())) kept.push_back(i);
  if (kept.empty()) return;  // an accessor without a view is zero
  const ComponentType index_type = kept.back() <= 0xff     ? ComponentType::kUint8
                                   : kept.back() <= 0xffff ? ComponentType::kUint16
                                                           : ComponentType::kUint32;
  const size_t index_bytes = component_bytes(index_type), value_bytes = layout->stored_bytes();
  if (kept.size() * (index_bytes + value_bytes) >= data.count * stride_in_view(*layout, target))
    return store_values(document, accessor, data, target);

  std::vector<uint8_t> stored_indices(kept.size() * index_bytes), stored_values(kept.size() * value_bytes);
  for (size_t i = 0; i < kept.size(); ++i) {
    std::memcpy(stored_indices.data() + i * index_bytes, &kept[i], index_bytes);  // little-endian
    store_element(data, kept[i], *layout, stored_values.data() + i * value_bytes);
  }
  const int64_t index_view = append_buffer_view(document, stored_indices);
  const int64_t value_view = append_buffer_view(document, stored_values);
  accessor["sparse"] = {
      {"count", kept.size()},
      {"indices", {{"bufferView", index_view}, {"componentType", static_cast<int>(index_type)}}},
      {"values", {{"bufferView", value_view}}}};
}

int64_t append_accessor(Document& document, const AccessorData& data, int target, bool with_bounds) {
  Json accessor = describe_stored(data);
  if (accessor.empty()) return -1;
  store_values(document, accessor, data, target);
  if (with_bounds && data.count > 0) set_bounds(accessor, data);
  Json& accessors = document.json["accessors"];
  if (!accessors.is_array()) accessors = Json::array();
  accessors.push_back(std::move(accessor));
  return static_cast<int64_t>(accessors.size() - 1);
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
