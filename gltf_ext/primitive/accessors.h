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
  Array<std::byte> values;  // tightly packed: strides, matrix padding, sparse and missing views resolved
};

// What accessors without a buffer view, all zeros but for sparse values, may stand for.
inline constexpr uint64_t kMaxUnbackedBytes = uint64_t{1} << 30;

Expected<AccessorData> read_accessor(const Document& document, int64_t index);

// Appends buffer view and accessor (count, type, min and max of float and integer data) and returns the
// accessor's index. `target` is 34962, 34963 or 0.
int64_t append_accessor(Document& document, const AccessorData& data, int target, bool with_bounds);

// Appends the data's values and makes `accessor` refer to them; its other members are the caller's.
void store_values(Document& document, Json& accessor, const AccessorData& data, int target);

// The same with the elements that are not zero only, as a sparse accessor, where that takes fewer bytes.
// Nothing is stored of data that is all zero.
void store_values_sparse(Document& document, Json& accessor, const AccessorData& data, int target);

// An accessor of such data, which an extension supplies: no bufferView, no bounds. The data's values may be
// left out. An empty object where no glTF type has so many components.
Json describe_stored(const AccessorData& data);

// Writes count, min, max of decoded data onto an accessor that keeps its other members, and takes its
// bufferView, byteOffset and sparse away: an accessor whose data an extension supplies.
void describe_decoded(Json& accessor, const AccessorData& data, bool with_bounds);

}  // namespace psplit
