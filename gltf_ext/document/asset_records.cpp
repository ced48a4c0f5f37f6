#include "gltf_ext/document/asset_records.h"

#include <algorithm>
#include <iterator>

#include "gltf_ext/document/meshopt_extension.h"
#include "gltf_ext/document/references.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

struct Shape {
  const char* name;
  uint8_t rows, columns;
};
constexpr Shape kShapes[] = {{"SCALAR", 1, 1}, {"VEC2", 2, 1}, {"VEC3", 3, 1}, {"VEC4", 4, 1},
                             {"MAT2", 2, 2},   {"MAT3", 3, 3}, {"MAT4", 4, 4}};

std::string numbered(const char* what, size_t index) { return std::string(what) + " " + std::to_string(index); }

// A byte count or offset. It is at most 2^53, so that no sum of two overflows.
std::optional<uint64_t> size_field(const Json& object, const char* name, int64_t fallback) {
  const auto value = integer_field_or(object, name, fallback);
  constexpr int64_t kMost = int64_t{1} << 53;
  if (!value || *value < 0 || *value > kMost) return std::nullopt;
  return static_cast<uint64_t>(*value);
}

// The index if it is below `size`, otherwise -1.
int64_t index_below(size_t size, const Json* index) {
  const int64_t value = index == nullptr ? -1 : integer_value(*index).value_or(-1);
  return value >= 0 && static_cast<uint64_t>(value) < size ? value : -1;
}

std::optional<ComponentType> component_type_of(const Json& object) {
  const auto type = integer_field(object, "componentType");
  if (!type || *type < 5120 || *type > 5126 || *type == 5124) return std::nullopt;
  return static_cast<ComponentType>(*type);
}

Expected<ElementLayout> element_layout(const Json& accessor) {
  const std::optional<ComponentType> component_type = component_type_of(accessor);
  const std::string* type = string_field(accessor, "type");
  if (!component_type) return invalid_input("no valid componentType");
  for (const Shape& shape : kShapes)
    if (type != nullptr && *type == shape.name)
      return ElementLayout{*component_type, shape.rows, shape.columns};
  return invalid_input("no valid type");
}

// Whether `count` elements that begin at `offset`, `stride` bytes apart, fit into `available` bytes.
bool elements_fit(const ElementLayout& layout, uint64_t offset, uint64_t stride, uint64_t count,
                  uint64_t available) {
  if (offset > available) return false;
  if (count == 0) return true;
  if (available - offset < layout.last_bytes()) return false;
  return count - 1 <= (available - offset - layout.last_bytes()) / stride;
}

class RecordReader {
 public:
  explicit RecordReader(const Json& json) : json_(json) {}

  Expected<AssetRecords> read() {
    for (const auto step :
         {&RecordReader::read_buffers, &RecordReader::read_views, &RecordReader::read_accessors,
          &RecordReader::read_meshes, &RecordReader::check_indices})
      if (Status status = (this->*step)(); !status.ok()) return status;
    return std::move(records_);
  }

 private:
  Status read_buffers() {
    for (size_t i = 0; i < array_size(json_, "buffers"); ++i) {
      const Json& buffer = json_["buffers"][i];
      const auto bytes = size_field(buffer, "byteLength", -1);
      if (!bytes) return invalid_input(numbered("buffer", i) + " has no valid byteLength");
      if (field(buffer, "uri") != nullptr && string_field(buffer, "uri") == nullptr)
        return invalid_input(numbered("buffer", i) + " has a uri that is not a string");
      records_.buffers.push_back({*bytes, is_meshopt_fallback(buffer)});
    }
    return {};
  }

  // That of a view, or of the compressed bytes of a view.
  Expected<BufferRange> buffer_range(const Json& json, const std::string& name) const {
    const int64_t buffer = index_below(records_.buffers.size(), field(json, "buffer"));
    if (buffer < 0) return invalid_input(name + " names a buffer that does not exist");
    const auto offset = size_field(json, "byteOffset", 0), bytes = size_field(json, "byteLength", -1);
    if (!offset || !bytes) return invalid_input(name + " has no valid byteOffset and byteLength");
    if (*offset + *bytes > records_.buffers[static_cast<size_t>(buffer)].bytes)
      return invalid_input(name + " reaches past its buffer");
    return BufferRange{buffer, *offset, *bytes};
  }

  Expected<MeshoptRecord> meshopt_record(const Json& extension, const std::string& name) const {
    const Expected<BufferRange> range = buffer_range(extension, name + ", compressed,");
    if (!range) return range.status();
    const auto stride = integer_field(extension, "byteStride"), count = integer_field(extension, "count");
    const std::string* mode = string_field(extension, "mode");
    const std::string* filter = string_field(extension, "filter");
    if (!stride || !count || mode == nullptr || *stride < 1 || *stride > 256 || *count < 0 ||
        *count > UINT32_MAX)
      return invalid_input(name + ", compressed by meshoptimizer, has no valid byteStride, count or mode");
    return MeshoptRecord{*range,
                         *mode,
                         filter == nullptr ? "NONE" : *filter,
                         static_cast<size_t>(*stride),
                         static_cast<size_t>(*count),
                         false};
  }

  Status read_views() {
    for (size_t i = 0; i < array_size(json_, "bufferViews"); ++i) {
      const Json& json = json_["bufferViews"][i];
      const std::string name = numbered("buffer view", i);
      const Expected<BufferRange> range = buffer_range(json, name);
      if (!range) return range.status();
      const auto stride = size_field(json, "byteStride", 0);
      if (!stride || *stride > 252 || *stride > range->bytes)
        return invalid_input(name + " has an invalid byteStride");
      ViewRecord& view = records_.views.emplace_back(ViewRecord{*range, static_cast<uint32_t>(*stride)});
      const Json* extension = meshopt_extension(json);
      if (extension == nullptr) continue;
      Expected<MeshoptRecord> meshopt = meshopt_record(*extension, name);
      if (!meshopt) return meshopt.status();
      view.meshopt = std::move(*meshopt);
      view.meshopt->is_khr = name_of_meshopt(json) == kMeshoptExtensions[1];
    }
    return {};
  }

  Expected<ElementsRecord> elements(const Json& json, const ElementLayout& layout, uint64_t count, bool strided,
                                    const std::string& name) const {
    const int64_t index = index_below(records_.views.size(), field(json, "bufferView"));
    if (index < 0) return invalid_input(name + " names a buffer view that does not exist");
    const auto offset = size_field(json, "byteOffset", 0);
    if (!offset) return invalid_input(name + " has an invalid byteOffset");
    const ViewRecord& view = records_.view(index);
    const uint64_t stride = strided && view.stride > 0 ? view.stride : layout.stored_bytes();
    if (stride < layout.last_bytes())
      return invalid_input(name + " has elements longer than its buffer view's stride");
    if (!elements_fit(layout, *offset, stride, count, view.range.bytes))
      return invalid_input(name + " reaches past its buffer view");
    return ElementsRecord{index, *offset};
  }

  Expected<SparseRecord> sparse_record(const Json& json, const AccessorRecord& accessor,
                                       const std::string& name) const {
    const auto count = size_field(json, "count", -1);
    const Json* indices = object_field(json, "indices");
    const Json* values = object_field(json, "values");
    if (!count || *count > accessor.count || indices == nullptr || values == nullptr)
      return invalid_input(name + " has no valid count, indices or values");
    const std::optional<ComponentType> type = component_type_of(*indices);
    if (type != ComponentType::kUint8 && type != ComponentType::kUint16 && type != ComponentType::kUint32)
      return invalid_input(name + " has an invalid index type");
    const auto of_indices = elements(*indices, {*type}, *count, false, name);
    if (!of_indices) return of_indices.status();
    const auto of_values = elements(*values, accessor.layout, *count, false, name);
    if (!of_values) return of_values.status();
    return SparseRecord{*count, *type, *of_indices, *of_values};
  }

  Status read_accessors() {
    for (size_t i = 0; i < array_size(json_, "accessors"); ++i) {
      const Json& json = json_["accessors"][i];
      const std::string name = numbered("accessor", i);
      const auto layout = element_layout(json);
      if (!layout) return invalid_input(name + ": " + layout.status().message());
      const auto count = size_field(json, "count", -1);
      if (!count || *count > UINT32_MAX) return invalid_input(name + " has no valid count");
      AccessorRecord accessor{*layout, bool_field_or(json, "normalized", false), static_cast<uint32_t>(*count)};
      if (field(json, "bufferView") != nullptr) {
        const auto found = elements(json, *layout, *count, true, name);
        if (!found) return found.status();
        accessor.elements = *found;
      }
      if (const Json* sparse = field(json, "sparse")) {
        const auto found = sparse_record(*sparse, accessor, name + ", sparse,");
        if (!found) return found.status();
        accessor.sparse = *found;
      }
      records_.accessors.push_back(std::move(accessor));
    }
    return {};
  }

  AttributeRecords attribute_records(const Json& json) const {
    AttributeRecords attributes;
    for (const auto& [semantic, index] : json.items())
      attributes.push_back({semantic, index_below(records_.accessors.size(), &index)});
    return attributes;
  }

  // Nothing if the primitive has no such extension.
  std::optional<DracoRecord> draco_record(const Json& json, const char* name,
                                          const PrimitiveRecord& primitive) const {
    const Json* extensions = object_field(json, "extensions");
    const Json* extension = extensions == nullptr ? nullptr : field(*extensions, name);
    if (extension == nullptr) return std::nullopt;
    DracoRecord draco;
    if (!extension->is_object()) {
      draco.status = invalid_input(std::string(name) + " is not an object");
      return draco;
    }
    draco.view = index_below(records_.views.size(), field(*extension, "bufferView"));
    draco.status = read_requests(*extension, primitive, draco.requests);
    if (draco.status.ok() && name == std::string_view(kExtensionName))
      draco.status = read_target_requests(*extension, primitive, draco.requests);
    if (draco.view < 0) draco.status = invalid_input("the extension has no bufferView");
    return draco;
  }

  Status read_requests(const Json& extension, const PrimitiveRecord& primitive,
                       std::vector<AttributeRequest>& requests) const {
    const Json* ids = object_field(extension, "attributes");
    if (ids == nullptr || ids->empty()) return invalid_input("the extension has no attributes");
    for (const auto& [semantic, id] : ids->items()) {
      if (target_of(semantic))
        return invalid_input("the extension's attribute " + semantic + " is a morph target");
      if (Status status = read_request(semantic, id, primitive, requests); !status.ok()) return status;
    }
    return {};
  }

  // The morph targets that a container stores: for each semantic an id for each target of the primitive, or -1.
  Status read_target_requests(const Json& extension, const PrimitiveRecord& primitive,
                              std::vector<AttributeRequest>& requests) const {
    const Json* targets = field(extension, "targets");
    if (targets == nullptr) return {};
    if (!targets->is_object()) return invalid_input("the extension's targets are not an object");
    for (const auto& [semantic, ids] : targets->items()) {
      if (!ids.is_array() || ids.size() != primitive.targets.size())
        return invalid_input("the extension's " + semantic + " of targets are not as many as the primitive's");
      for (size_t t = 0; t < ids.size(); ++t) {
        if (integer_value(ids[t]) == -1) continue;
        Status status = read_request(name_of_target(t, semantic), ids[t], primitive, requests);
        if (!status.ok()) return status;
      }
    }
    return {};
  }

  Status read_request(const std::string& semantic, const Json& id, const PrimitiveRecord& primitive,
                      std::vector<AttributeRequest>& requests) const {
    const auto unique_id = integer_value(id);
    if (!unique_id || *unique_id < 0 || *unique_id > UINT32_MAX)
      return invalid_input("the extension's attribute " + semantic + " has no unique id");
    const int64_t index = primitive.accessor_of(semantic);
    if (index < 0) return invalid_input("the extension's attribute " + semantic + " has no accessor");
    const AccessorRecord& accessor = records_.accessor(index);
    requests.push_back({semantic, static_cast<uint32_t>(*unique_id), accessor.layout.component_type,
                        accessor.layout.component_count(), accessor.normalized});
    return {};
  }

  Expected<PrimitiveRecord> primitive_record(const Json& json) const {
    const Json* attributes = object_field(json, "attributes");
    if (attributes == nullptr) return invalid_input("no attributes");
    PrimitiveRecord primitive;
    primitive.attributes = attribute_records(*attributes);
    primitive.indices = index_below(records_.accessors.size(), field(json, "indices"));
    const auto mode = integer_field_or(json, "mode", 4);
    primitive.mode = mode && *mode >= 0 && *mode <= 6 ? static_cast<int>(*mode) : -1;
    primitive.material = integer_field_or(json, "material", -1).value_or(-1);
    const Json* targets = field(json, "targets");
    if (targets != nullptr && !targets->is_array()) return invalid_input("targets is not an array");
    for (size_t t = 0; targets != nullptr && t < targets->size(); ++t) {
      if (!(*targets)[t].is_object()) return invalid_input("targets is not an array of objects");
      primitive.targets.push_back(attribute_records((*targets)[t]));
    }
    primitive.patches = draco_record(json, kExtensionName, primitive);
    primitive.stock = draco_record(json, kStockExtensionName, primitive);
    if (primitive.mode < 0) primitive.status = invalid_input("an unknown mode");
    for (const auto& [name, draco] :
         {std::pair(kExtensionName, &primitive.patches), std::pair(kStockExtensionName, &primitive.stock)})
      if (*draco && primitive.status.ok() && !json["extensions"][name].is_object())
        primitive.status = (*draco)->status;
    return primitive;
  }

  // Loaders without the extension show the coarse primitives. Nothing else reads them.
  Status check_coarse(const Json& mesh) const {
    const Json* coarse = other_primitives(mesh);
    for (size_t i = 0; coarse != nullptr && i < coarse->size(); ++i)
      if (const auto primitive = primitive_record((*coarse)[i]); !primitive)
        return invalid_input(numbered("coarse primitive", i) + ": " + primitive.status().message());
    return {};
  }

  Status read_meshes() {
    for (size_t i = 0; i < array_size(json_, "meshes"); ++i) {
      Place place{.mesh = static_cast<int64_t>(i)};
      const Json* primitives = array_field(json_["meshes"][i], "primitives");
      if (primitives == nullptr) return invalid_input("no array of primitives", place);
      std::vector<PrimitiveRecord>& mesh = records_.meshes.emplace_back();
      for (const Json& json : *primitives) {
        place.primitive = static_cast<int64_t>(mesh.size());
        Expected<PrimitiveRecord> primitive = primitive_record(json);
        if (!primitive) return primitive.status().at(place);
        primitive->status = std::move(primitive->status).at(place);
        mesh.push_back(std::move(*primitive));
      }
      place.primitive = -1;
      if (Status status = check_coarse(json_["meshes"][i]); !status.ok()) return std::move(status).at(place);
    }
    return {};
  }

  Status check_indices() {
    bool accessors_exist = true, views_exist = true;
    for_each_accessor_reference(json_, [&](const Json& index) {
      accessors_exist &= index_below(records_.accessors.size(), &index) >= 0;
    });
    if (!accessors_exist)
      return invalid_input("a mesh, animation, skin or node names an accessor that does not exist");
    for_each_buffer_view_reference(
        json_, [&](const Json& index) { views_exist &= index_below(records_.views.size(), &index) >= 0; });
    if (!views_exist) return invalid_input("an image or an extension names a buffer view that does not exist");
    return {};
  }

  const Json& json_;
  AssetRecords records_;
};

}  // namespace

const char* type_name(const ElementLayout& layout) {
  return std::find_if(
             std::begin(kShapes), std::end(kShapes),
             [&](const Shape& shape) { return shape.rows == layout.rows && shape.columns == layout.columns; })
      ->name;
}

bool needs_mesh_quantization(std::string_view semantic, ComponentType component_type, bool normalized) {
  if (component_type == ComponentType::kFloat32) return false;
  if (semantic == "POSITION" || semantic == "NORMAL" || semantic == "TANGENT") return true;
  const bool is_share =
      normalized && (component_type == ComponentType::kUint8 || component_type == ComponentType::kUint16);
  return semantic.starts_with("TEXCOORD_") && !is_share;
}

std::optional<ElementLayout> layout_of(ComponentType component_type, uint8_t component_count) {
  for (const Shape& shape : kShapes)
    if (shape.rows * shape.columns == component_count)
      return ElementLayout{component_type, shape.rows, shape.columns};
  return std::nullopt;
}

bool DracoRecord::stores(const std::string& semantic) const {
  return std::any_of(requests.begin(), requests.end(),
                     [&](const AttributeRequest& request) { return request.semantic == semantic; });
}

int64_t PrimitiveRecord::accessor_of(const std::string& name) const {
  const std::optional<MorphTarget> target = target_of(name);
  if (target && target->number >= targets.size()) return -1;
  const std::string& semantic = target ? target->semantic : name;
  const AttributeRecords& list = target ? targets[target->number] : attributes;
  const auto found = std::find_if(list.begin(), list.end(), [&](const AttributeRecord& attribute) {
    return attribute.semantic == semantic;
  });
  return found == list.end() ? -1 : found->accessor;
}

uint64_t AssetRecords::points_of(const PrimitiveRecord& primitive) const {
  const int64_t position = primitive.accessor_of("POSITION");
  return position < 0 ? 0 : accessor(position).count;
}

uint64_t AssetRecords::file_bytes(const AccessorRecord& accessor) const {
  const ElementLayout& layout = accessor.layout;
  uint64_t bytes = 0;
  if (accessor.has_view())
    bytes += view(accessor.elements.view).file_bytes_of(accessor.count * layout.stored_bytes());
  if (const auto& sparse = accessor.sparse) {
    bytes += view(sparse->indices.view).file_bytes_of(sparse->count * component_bytes(sparse->index_type));
    bytes += view(sparse->values.view).file_bytes_of(sparse->count * layout.stored_bytes());
  }
  return bytes;
}

uint64_t AssetRecords::faces_of(const PrimitiveRecord& primitive) const {
  const uint64_t corners = primitive.indices < 0 ? points_of(primitive) : accessor(primitive.indices).count;
  if (primitive.mode == 4 || primitive.draco() != nullptr) return corners / 3;
  return primitive.has_triangles() && corners > 2 ? corners - 2 : 0;
}

bool AssetRecords::has_plain_data(const PrimitiveRecord& primitive) const {
  const auto has_view = [&](int64_t index) { return index >= 0 && accessor(index).has_view(); };
  return has_view(primitive.indices) &&
         std::all_of(primitive.attributes.begin(), primitive.attributes.end(),
                     [&](const AttributeRecord& attribute) { return has_view(attribute.accessor); });
}

std::optional<BufferRange> range_in_memory(const Document& document, const Json& view) {
  const int64_t buffer = index_below(document.buffers.size(), field(view, "buffer"));
  if (buffer < 0) return std::nullopt;
  const auto size_of = [&](const char* name) {
    return static_cast<uint64_t>(std::max<int64_t>(integer_field(view, name).value_or(0), 0));
  };
  const BufferRange range{buffer, size_of("byteOffset"), size_of("byteLength")};
  const uint64_t size = document.buffers[static_cast<size_t>(buffer)].size();
  if (range.offset > size || range.bytes > size - range.offset) return std::nullopt;
  return range;
}

Expected<AssetRecords> read_records(const Json& json) { return RecordReader(json).read(); }

}  // namespace psplit
