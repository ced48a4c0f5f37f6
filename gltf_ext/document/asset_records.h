// The geometry in the JSON of a document, read and checked once. Every index in the records names an existing
// record, or is -1 where the JSON has none; every range lies within its buffer, view or accessor.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "gltf_ext/document/document.h"
#include "gltf_ext/json/extension_names.h"
#include "psplit/decode.h"

namespace psplit {

struct BufferRange {
  int64_t buffer = 0;
  uint64_t offset = 0, bytes = 0;
};

struct BufferRecord {
  uint64_t bytes = 0;        // as stated; a buffer in memory has them all, or none
  bool is_fallback = false;  // a placeholder for the data that meshoptimizer decodes: it may have no bytes
};

// The compressed bytes of a buffer view (EXT_meshopt_compression, KHR_meshopt_compression).
struct MeshoptRecord {
  BufferRange range;
  std::string mode, filter;
  size_t stride = 0, count = 0;
  bool is_khr = false;  // whose codec of attributes may be of version 1

  size_t decoded_bytes() const { return stride * count; }
};

struct ViewRecord {
  BufferRange range;
  uint32_t stride = 0;  // 0: none is stated
  std::optional<MeshoptRecord> meshopt{};

  // The bytes that a file has for it.
  uint64_t file_bytes() const { return meshopt ? meshopt->range.bytes : range.bytes; }
  // The share of these that `bytes` of its decoded bytes take.
  uint64_t file_bytes_of(uint64_t bytes) const {
    if (!meshopt || range.bytes == 0) return bytes;
    return static_cast<uint64_t>(static_cast<double>(bytes) * static_cast<double>(file_bytes()) /
                                 static_cast<double>(range.bytes));
  }
};

// How one element of an accessor is stored. Columns of a matrix start on 4-byte boundaries.
struct ElementLayout {
  ComponentType component_type = ComponentType::kFloat32;
  uint8_t rows = 1;
  uint8_t columns = 1;

  uint8_t component_count() const { return static_cast<uint8_t>(rows * columns); }
  size_t column_bytes() const { return rows * component_bytes(component_type); }
  size_t column_stride() const { return columns == 1 ? column_bytes() : (column_bytes() + 3) / 4 * 4; }
  size_t packed_bytes() const { return column_bytes() * columns; }   // without padding
  size_t stored_bytes() const { return column_stride() * columns; }  // the stride if none is stated
  // The bytes of the last element: nothing pads its last column.
  size_t last_bytes() const { return column_stride() * (columns - 1u) + column_bytes(); }
};

// The name that glTF has for the type: "VEC3".
const char* type_name(const ElementLayout& layout);
// The layout of values with that many components; nothing if glTF has no such type.
std::optional<ElementLayout> layout_of(ComponentType component_type, uint8_t component_count);
// Whether glTF allows this type of an attribute, or of a target of it, only with KHR_mesh_quantization.
bool needs_mesh_quantization(std::string_view semantic, ComponentType component_type, bool normalized);

// Elements of a buffer view, from an offset on.
struct ElementsRecord {
  int64_t view = -1;
  uint64_t offset = 0;
};

struct SparseRecord {
  uint64_t count = 0;
  ComponentType index_type = ComponentType::kUint8;  // unsigned
  ElementsRecord indices{}, values{};

  uint64_t stored_bytes(const ElementLayout& layout) const {
    return count * (component_bytes(index_type) + layout.stored_bytes());
  }
};

struct AccessorRecord {
  ElementLayout layout;
  bool normalized = false;
  uint32_t count = 0;
  ElementsRecord elements{};  // without a view, all elements are zero
  std::optional<SparseRecord> sparse{};

  bool has_view() const { return elements.view >= 0; }
  // Its views, once for each place that names one.
  std::vector<int64_t> views() const {
    std::vector<int64_t> used;
    if (has_view()) used.push_back(elements.view);
    if (sparse) used.insert(used.end(), {sparse->indices.view, sparse->values.view});
    return used;
  }
  uint64_t packed_bytes() const { return uint64_t{count} * layout.packed_bytes(); }
  // The bytes that buffer views have for it, without gaps between elements.
  uint64_t stored_bytes() const {
    return (has_view() ? count * layout.stored_bytes() : 0) + (sparse ? sparse->stored_bytes(layout) : 0);
  }
};

struct AttributeRecord {
  std::string semantic;
  int64_t accessor = -1;

  // <=> would be shorter, but strings lack it in some standard libraries.
  friend bool operator==(const AttributeRecord& a, const AttributeRecord& b) {
    return a.semantic == b.semantic && a.accessor == b.accessor;
  }
  friend bool operator<(const AttributeRecord& a, const AttributeRecord& b) {
    return std::tie(a.semantic, a.accessor) < std::tie(b.semantic, b.accessor);
  }
};
using AttributeRecords = std::vector<AttributeRecord>;  // in the order of the JSON

// One of the two Draco extensions of a primitive.
struct DracoRecord {
  int64_t view = -1;
  // The stored attributes, with the types of their accessors. Morph targets have the names of name_of_target.
  std::vector<AttributeRequest> requests{};
  Status status{};  // the error in the extension

  bool stores(const std::string& semantic) const;
};

enum class PrimitiveStorage { kPlain, kPatches, kStockDraco };

struct PrimitiveRecord {
  int mode = 4;  // -1 if glTF has no such mode
  AttributeRecords attributes{};
  int64_t indices = -1;
  int64_t material = -1;
  std::vector<AttributeRecords> targets{};
  std::optional<DracoRecord> patches{}, stock{};
  Status status{};  // an unknown mode, or an extension that is not an object: no data can be read

  bool has_triangles() const { return mode >= 4; }  // strips and fans become lists
  PrimitiveStorage storage() const {
    return patches ? PrimitiveStorage::kPatches
           : stock ? PrimitiveStorage::kStockDraco
                   : PrimitiveStorage::kPlain;
  }
  // The extension that counts; null if the primitive is plain.
  const DracoRecord* draco() const { return patches ? &*patches : stock ? &*stock : nullptr; }
  // The accessor of an attribute, or of the deltas of a target by their name (name_of_target), or -1.
  int64_t accessor_of(const std::string& name) const;
};

struct AssetRecords {
  std::vector<BufferRecord> buffers{};
  std::vector<ViewRecord> views{};
  std::vector<AccessorRecord> accessors{};
  std::vector<std::vector<PrimitiveRecord>> meshes{};  // the primitives of each mesh

  const ViewRecord& view(int64_t index) const { return views[static_cast<size_t>(index)]; }
  const AccessorRecord& accessor(int64_t index) const { return accessors[static_cast<size_t>(index)]; }
  const PrimitiveRecord& primitive(PrimitiveId id) const { return meshes[id.mesh][id.primitive]; }

  // Whether meshoptimizer compressed one of the accessor's views.
  bool is_meshopt(const AccessorRecord& accessor) const {
    const std::vector<int64_t> used = accessor.views();
    return std::any_of(used.begin(), used.end(),
                       [&](int64_t index) { return view(index).meshopt.has_value(); });
  }

  // The bytes that a file has for the accessor's elements. Of a view that meshoptimizer compressed it is the
  // elements' share.
  uint64_t file_bytes(const AccessorRecord& accessor) const;

  // The points and faces that the accessors state: a strip or a fan has a face for each point after the second.
  // 0 where nothing is stated, and for lines and points. A compressed primitive is a list.
  uint64_t points_of(const PrimitiveRecord& primitive) const;
  uint64_t faces_of(const PrimitiveRecord& primitive) const;

  // Whether accessors of indices and of all attributes have data in buffer views.
  bool has_plain_data(const PrimitiveRecord& primitive) const;
};

// The bytes that the JSON of a buffer view, or of its compressed bytes, names. Nothing if they are not in
// memory.
std::optional<BufferRange> range_in_memory(const Document& document, const Json& view);

// Checks every index of a buffer, buffer view or accessor in the whole tree, and every extent against the
// lengths that the JSON states. Unknown members are allowed. Errors: kInvalidInput.
Expected<AssetRecords> read_records(const Json& json);

}  // namespace psplit
