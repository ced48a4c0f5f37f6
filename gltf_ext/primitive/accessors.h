// glTF accessors to plain arrays and back.
#pragma once

#include "gltf_ext/document/document.h"
#include "src/mesh/mesh.h"

namespace psplit {

struct AccessorData {
  ComponentType component_type = ComponentType::kFloat32;
  uint8_t component_count = 1;
  bool normalized = false;
  uint32_t count = 0;
  Array<std::byte> values;  // tightly packed, without strides or matrix padding; sparse values applied
};

// The most bytes of an accessor without a buffer view, which is all zeros except for sparse values.
inline constexpr uint64_t kMaxUnbackedBytes = uint64_t{1} << 30;

Expected<AccessorData> read_accessor(const Document& document, int64_t index);

// Appends a buffer view and its accessor, with min and max if `with_bounds` is true. Returns the accessor's
// index, or -1 if no glTF type has this number of components. `target` is 34962, 34963 or 0.
int64_t append_accessor(Document& document, const AccessorData& data, int target, bool with_bounds);

// Appends the values as a buffer view and makes `accessor` refer to it. The caller sets its other members.
void store_values(Document& document, Json& accessor, const AccessorData& data, int target);

// The same, but as a sparse accessor of the elements that are not zero, if that takes fewer bytes. If all
// elements are zero, nothing is stored.
void store_values_sparse(Document& document, Json& accessor, const AccessorData& data, int target);

// An accessor that describes data without bufferView and bounds, for example because an extension supplies it.
// `data.values` is not used. Returns an empty object if no glTF type has this number of components.
Json describe_stored(const AccessorData& data);

// Makes `accessor` describe decoded data that an extension supplies: sets count, min and max, and removes
// bufferView, byteOffset and sparse. Its other members stay.
void describe_decoded(Json& accessor, const AccessorData& data, bool with_bounds);

}  // namespace psplit
