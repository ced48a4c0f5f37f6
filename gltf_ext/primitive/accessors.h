// glTF accessors to plain arrays and back.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>

#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/json/bound_json.h"
#include "psplit/mesh.h"
#include "system/operating_system.h"

namespace psplit {

// The mode of a primitive of points.
inline constexpr int kPointsMode = 0;

// How buffer views store the values; nothing if no glTF type has this number of components.
inline std::optional<ElementLayout> layout_of(const ValuesView& values) {
  return layout_of(values.component_type, values.component_count);
}

// Values may be in a mapped file: functions that take a view go through it in order, and release what they have
// read (system/mapped_file.h). Calls visit(first, end) for the values in steps of about kReleaseStep bytes, and
// releases the memory of each step. `visit` returns whether to continue. Returns false if it stopped.
template <typename Visit>
bool for_each_step(const ValuesView& data, Visit&& visit) {
  const size_t step = data.step(), values = std::max<size_t>(1, static_cast<size_t>(kReleaseStep) / step);
  for (size_t first = 0; first < data.count; first += values) {
    const size_t end = std::min<size_t>(first + values, data.count);
    if (!visit(first, end)) return false;
    release_mapped({reinterpret_cast<const uint8_t*>(data.at(first)), (end - first) * step});
  }
  return true;
}

struct AccessorData {
  ComponentType component_type = ComponentType::kFloat32;
  uint8_t component_count = 1;
  bool normalized = false;
  uint32_t count = 0;
  Array<std::byte> values;  // tightly packed, without strides or matrix padding; sparse values applied

  operator ValuesView() const { return {component_type, component_count, normalized, count, values}; }
};

// The most bytes of an accessor without a buffer view, which is all zeros except for sparse values.
inline constexpr uint64_t kMaxUnbackedBytes = uint64_t{1} << 30;

// The values of an accessor that exists. Errors: kInvalidInput if it would have more zeros than that, or if a
// sparse index is past its end; kUnsupported if its bytes are missing (buffer_view_bytes).
Expected<AccessorData> read_accessor(const Document& document, int64_t index);
// Only `count` values from `first` on, which must exist. Errors: as for the whole accessor.
Expected<AccessorData> read_accessor(const Document& document, int64_t index, uint32_t first, uint32_t count);

// The values where they are, in the document's buffer. kUnsupported if they are not stored as such: a sparse
// accessor, one without a buffer view, a matrix with padded columns; or if their bytes are missing.
Expected<ValuesView> accessor_view(const Document& document, int64_t index);

// glTF's `target` of a buffer view.
inline constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;

// Appends a buffer view and its accessor, with min and max if `with_bounds` is true. Returns the accessor's
// index, or -1 if no glTF type has this number of components. `target` may be 0, for none. An `owner` keeps the
// values unchanged: large ones that are stored as they are become a buffer without a copy.
int64_t append_accessor(Document& document, const ValuesView& data, int target, bool with_bounds,
                        std::shared_ptr<const void> owner = nullptr);

// Appends the values as a buffer view and makes `accessor` refer to it. The caller sets its other members.
// An `owner` means what it means to append_accessor.
void store_values(Document& document, Json& accessor, const ValuesView& data, int target,
                  std::shared_ptr<const void> owner = nullptr);

// Appends a view of bytes that a buffer has already, laid out as store_values does it, and makes `accessor`
// refer to it.
void place_values(Document& document, Json& accessor, const ValuesView& data, int target, size_t buffer,
                  uint64_t offset);
// Writes the values as store_values does, stored_stride(data, target) bytes apart.
void write_values(const ValuesView& data, int target, uint8_t* to);

// The type of the indices of a new accessor. 16 bits hold indices up to 65534: 65535 restarts primitives.
constexpr ComponentType index_type(uint32_t point_count) {
  return point_count <= 65535 ? ComponentType::kUint16 : ComponentType::kUint32;
}
// The bytes from one value to the next that store_values chooses.
size_t stored_stride(const ValuesView& data, int target);

// Whether -0 is stored, or is as good as 0. Exporters write it in most deltas that are zero.
enum class ZeroSign { kKept, kIgnored };

// What a sparse accessor stores: the elements that are not zero, in their order.
std::vector<uint32_t> elements_that_are_not_zero(const ValuesView& data, ZeroSign sign);
// The bytes of these elements and of their indices.
uint64_t sparse_bytes(const ValuesView& data, std::span<const uint32_t> kept);
struct SparseData {
  ComponentType index_type = ComponentType::kUint8;
  std::vector<uint8_t> indices, values;
};
SparseData sparse_data(const ValuesView& data, std::span<const uint32_t> kept);

// store_values, but as a sparse accessor if that takes fewer bytes. If all elements are zero, nothing is
// stored.
void store_values_sparse(Document& document, Json& accessor, const ValuesView& data, int target);

// An accessor that describes data without bufferView and bounds, for example because an extension supplies it.
// `data.bytes` is not used. Returns an empty object if no glTF type has this number of components.
Json describe_stored(const ValuesView& data);

// Whether a bound that an accessor states is `exact`: readers compare bounds as floats.
bool is_bound(const Json* stated, const Json& exact);

// Makes `accessor` describe decoded data that an extension supplies: sets count, min and max, and removes
// bufferView, byteOffset and sparse. Its other members stay.
void describe_decoded(Json& accessor, const ValuesView& data, bool with_bounds);

}  // namespace psplit
