#include "gltf_ext/primitive/read_primitives.h"

#include <cstring>

#include "gltf_ext/document/element_layout.h"
#include "gltf_ext/json/json_fields.h"
#include "src/container/patch_container.h"

namespace psplit {
namespace {

Place place_of(PrimitiveId id) {
  return {.mesh = static_cast<int64_t>(id.mesh), .primitive = static_cast<int64_t>(id.primitive)};
}

const Json* find_primitive(const Document& document, PrimitiveId id) {
  const Json* mesh = top_level_object(document.json, "meshes", static_cast<int64_t>(id.mesh));
  const Json* primitives = mesh == nullptr ? nullptr : array_field(*mesh, "primitives");
  const Json* primitive =
      primitives == nullptr ? nullptr : element(*primitives, static_cast<int64_t>(id.primitive));
  return primitive != nullptr && primitive->is_object() ? primitive : nullptr;
}

// The attributes that a Draco extension stores, with the types of their accessors.
Expected<std::vector<AttributeRequest>> requests_of(const Document& document, const Json& primitive,
                                                    const Json& extension) {
  const Json* ids = object_field(extension, "attributes");
  const Json* attributes = object_field(primitive, "attributes");
  if (ids == nullptr || ids->empty()) return invalid_input("the extension has no attributes");
  std::vector<AttributeRequest> requests;
  for (const auto& [semantic, id] : ids->items()) {
    const auto unique_id = integer_value(id);
    if (!unique_id || *unique_id < 0 || *unique_id > 0xffffffffLL)
      return invalid_input("the extension's attribute " + semantic + " has no unique id");
    const auto index = attributes == nullptr ? std::nullopt : integer_field(*attributes, semantic.c_str());
    const Json* accessor = index ? top_level_object(document.json, "accessors", *index) : nullptr;
    if (accessor == nullptr) return invalid_input("the extension's attribute " + semantic + " has no accessor");
    const auto layout = element_layout(*accessor);
    if (!layout) return layout.status();
    requests.push_back({semantic, static_cast<uint32_t>(*unique_id), layout->component_type,
                        layout->component_count(), bool_field_or(*accessor, "normalized", false)});
  }
  return requests;
}

Expected<std::span<const uint8_t>> extension_bytes(const Document& document, const Json& extension) {
  const auto view = integer_field(extension, "bufferView");
  if (!view) return invalid_input("the extension has no bufferView");
  return buffer_view_bytes(document, *view);
}

Expected<Attribute> read_attribute(const Document& document, const std::string& semantic, const Json& index) {
  const auto number = integer_value(index);
  if (!number) return invalid_input("attribute " + semantic + " has no accessor");
  Expected<AccessorData> data = read_accessor(document, *number);
  if (!data) return Status(data.status().code(), "attribute " + semantic + ": " + data.status().message());
  return Attribute{semantic, data->component_type, data->component_count, data->normalized,
                   std::move(data->values)};
}

// Checks an attribute before memory is allocated for it.
Status check_count(const Document& document, const std::string& semantic, const Json& index,
                   uint32_t point_count) {
  const Json* accessor = top_level_object(document.json, "accessors", integer_value(index).value_or(-1));
  const auto count = accessor == nullptr ? std::nullopt : integer_field(*accessor, "count");
  if (count == point_count) return {};
  return invalid_input("attribute " + semantic + " has " + std::to_string(count.value_or(0)) +
                       " elements, others have " + std::to_string(point_count));
}

// Reads the attributes that the mesh does not have yet from their accessors.
Status read_plain_attributes(const Document& document, const Json& primitive, Mesh& mesh) {
  const Json* attributes = object_field(primitive, "attributes");
  if (attributes == nullptr) return invalid_input("no attributes");
  bool first = mesh.attributes.empty();
  for (const auto& [semantic, index] : attributes->items()) {
    if (mesh.find(semantic) != nullptr) continue;
    if (!first)
      if (Status status = check_count(document, semantic, index, mesh.point_count); !status.ok()) return status;
    Expected<Attribute> attribute = read_attribute(document, semantic, index);
    if (!attribute) return attribute.status();
    const size_t count = attribute->values.size() / attribute->stride();
    if (first) mesh.point_count = static_cast<uint32_t>(count);
    first = false;
    mesh.attributes.push_back(std::move(*attribute));
  }
  if (mesh.find("POSITION") == nullptr) return unsupported("no POSITION");
  return {};
}

Expected<std::vector<uint32_t>> read_indices(const Document& document, const Json& primitive,
                                             uint32_t point_count) {
  std::vector<uint32_t> indices;
  if (field(primitive, "indices") == nullptr) {
    indices.resize(point_count);
    for (uint32_t i = 0; i < point_count; ++i) indices[i] = i;
    return indices;
  }
  const auto number = integer_field(primitive, "indices");
  if (!number) return invalid_input("indices is not an accessor");
  const Expected<AccessorData> data = read_accessor(document, *number);
  if (!data) return data.status();
  const size_t width = component_bytes(data->component_type);
  if (data->component_count != 1 ||
      (data->component_type != ComponentType::kUint8 && data->component_type != ComponentType::kUint16 &&
       data->component_type != ComponentType::kUint32))
    return invalid_input("indices are not unsigned scalars");
  const uint32_t restart = width == 4 ? UINT32_MAX : (1u << 8 * width) - 1;
  indices.resize(data->count);
  for (size_t i = 0; i < indices.size(); ++i) {
    std::memcpy(&indices[i], data->values.data() + i * width, width);
    if (indices[i] == restart)
      return invalid_input("index " + std::to_string(i) + " is " + std::to_string(restart) +
                           ", which restarts primitives and glTF forbids");
    if (indices[i] >= point_count)
      return invalid_input("index " + std::to_string(i) + " is " + std::to_string(indices[i]) +
                           ", but there are " + std::to_string(point_count) + " points");
  }
  return indices;
}

// Triangles of a list, strip or fan, with the orientation that glTF defines.
Expected<Array<std::array<uint32_t, 3>>> triangles(const std::vector<uint32_t>& indices, int64_t mode) {
  Array<std::array<uint32_t, 3>> faces;
  if (mode == 4) {
    if (indices.size() % 3 != 0)
      return invalid_input("a triangle list has " + std::to_string(indices.size()) + " indices");
    for (size_t i = 0; i < indices.size(); i += 3)
      faces.push_back({indices[i], indices[i + 1], indices[i + 2]});
    return faces;
  }
  for (size_t i = 2; i < indices.size(); ++i) {
    if (mode == 6)
      faces.push_back({indices[i - 1], indices[i], indices[0]});
    else if (i % 2 == 0)
      faces.push_back({indices[i - 2], indices[i - 1], indices[i]});
    else
      faces.push_back({indices[i - 2], indices[i], indices[i - 1]});
  }
  return faces;
}

// Completes `mesh`, which holds the attributes that an extension stores, with the plain data of the primitive.
Expected<Mesh> read_plain(const Document& document, PrimitiveId id, PrimitiveStorage storage, Mesh mesh) {
  const Json& primitive = *find_primitive(document, id);
  if (Status status = read_plain_attributes(document, primitive, mesh); !status.ok()) return status;
  if (storage == PrimitiveStorage::kStockDraco) {
    const auto index = integer_field(primitive, "indices");
    const Json* accessor = index ? top_level_object(document.json, "accessors", *index) : nullptr;
    const std::string* type = accessor == nullptr ? nullptr : string_field(*accessor, "type");
    if (type != nullptr && *type != "SCALAR") return invalid_input("indices are not scalars");
  }
  if (storage != PrimitiveStorage::kPlain) return mesh;
  const auto indices = read_indices(document, primitive, mesh.point_count);
  if (!indices) return indices.status();
  auto faces = triangles(*indices, *integer_field_or(primitive, "mode", 4));
  if (!faces) return faces.status();
  mesh.faces = std::move(*faces);
  return mesh;
}

// Checks that the primitive has triangles. Returns how they are stored.
Expected<PrimitiveStorage> triangle_storage(const Document& document, PrimitiveId id) {
  const Expected<PrimitiveKind> kind = primitive_kind(document, id);
  if (!kind) return kind.status();
  if (kind->triangles) return kind->storage;
  const auto mode = integer_field_or(*find_primitive(document, id), "mode", 4);
  return unsupported("mode " + std::to_string(mode.value_or(-1)) + " has no triangles");
}

}  // namespace

Expected<PrimitiveKind> primitive_kind(const Document& document, PrimitiveId id) {
  const Json* primitive = find_primitive(document, id);
  if (primitive == nullptr) return invalid_input("no such primitive", place_of(id));
  const auto mode = integer_field_or(*primitive, "mode", 4);
  if (!mode || *mode < 0 || *mode > 6) return invalid_input("an unknown mode", place_of(id));
  for (const char* name : {kExtensionName, kStockExtensionName}) {
    const Json* extensions = object_field(*primitive, "extensions");
    const Json* extension = extensions == nullptr ? nullptr : field(*extensions, name);
    if (extension != nullptr && !extension->is_object())
      return invalid_input(std::string(name) + " is not an object", place_of(id));
  }
  PrimitiveKind kind;
  kind.triangles = *mode >= 4;
  if (extension_field(*primitive, kExtensionName) != nullptr)
    kind.storage = PrimitiveStorage::kPatches;
  else if (extension_field(*primitive, kStockExtensionName) != nullptr)
    kind.storage = PrimitiveStorage::kStockDraco;
  return kind;
}

Expected<Mesh> read_primitive(const Document& document, PrimitiveId id, const DecodeBackend& backend,
                              const ThreadPool& pool) {
  return std::move(read_primitives(document, {&id, 1}, backend, pool).front());
}

std::vector<Expected<Mesh>> read_primitives(const Document& document, std::span<const PrimitiveId> ids,
                                            const DecodeBackend& backend, const ThreadPool& pool,
                                            const Progress& progress) {
  std::vector<Expected<Mesh>> meshes(ids.size(), Mesh());
  std::vector<PrimitiveStorage> storages(ids.size(), PrimitiveStorage::kPlain);
  std::vector<StoredPrimitive> stored;
  std::vector<PatchContainer> containers;
  std::vector<size_t> decoded;  // indices into `ids`
  for (size_t i = 0; i < ids.size(); ++i) {
    const Expected<PrimitiveStorage> storage = triangle_storage(document, ids[i]);
    if (!storage) {
      meshes[i] = storage.status();
      continue;
    }
    storages[i] = *storage;
    if (*storage == PrimitiveStorage::kPlain) continue;
    auto primitive = stored_primitive(
        document, ids[i], *storage == PrimitiveStorage::kPatches ? kExtensionName : kStockExtensionName);
    if (!primitive) {
      meshes[i] = primitive.status();
      continue;
    }
    Expected<PatchContainer> container = *storage == PrimitiveStorage::kPatches
                                             ? open_container(primitive->bytes)
                                             : open_stream(primitive->bytes);
    if (!container) {
      meshes[i] = container.status();
      continue;
    }
    stored.push_back(std::move(*primitive));
    containers.push_back(std::move(*container));
    decoded.push_back(i);
  }
  std::vector<DecodeTask> tasks;
  for (size_t n = 0; n < stored.size(); ++n) tasks.push_back({&containers[n], stored[n].requests});
  if (!tasks.empty()) {
    std::vector<Expected<Mesh>> results = backend.decode(tasks, pool, progress);
    for (size_t n = 0; n < tasks.size(); ++n) meshes[decoded[n]] = std::move(results[n]);
  }
  pool.for_each(ids.size(), [&](size_t i) {
    if (meshes[i]) meshes[i] = read_plain(document, ids[i], storages[i], std::move(*meshes[i]));
    if (!meshes[i]) meshes[i] = meshes[i].status().at(place_of(ids[i])).at({.file = document.source.string()});
  });
  return meshes;
}

Expected<LinesOrPoints> read_lines_or_points(const Document& document, PrimitiveId id) {
  const Json* primitive = find_primitive(document, id);
  const auto mode = primitive == nullptr ? std::nullopt : integer_field_or(*primitive, "mode", 4);
  if (!mode || *mode < 0 || *mode > 3) return unsupported("has neither lines nor points", place_of(id));
  LinesOrPoints result;
  result.corner_count = *mode == 0 ? 1 : 2;
  if (Status status = read_plain_attributes(document, *primitive, result.mesh); !status.ok())
    return std::move(status).at(place_of(id));
  const auto indices = read_indices(document, *primitive, result.mesh.point_count);
  if (!indices) return indices.status().at(place_of(id));
  const size_t count = indices->size();
  if (*mode == 0)
    for (const uint32_t point : *indices) result.mesh.faces.push_back({point, point, point});
  else
    for (size_t i = 1; i < count; i += *mode == 1 ? 2 : 1)
      result.mesh.faces.push_back({(*indices)[i - 1], (*indices)[i], (*indices)[i]});
  if (*mode == 2 && count > 2)
    result.mesh.faces.push_back({indices->back(), indices->front(), indices->front()});
  return result;
}

Expected<std::vector<MorphAttribute>> read_morph_targets(const Document& document, PrimitiveId id,
                                                         std::optional<uint32_t> point_count) {
  const Json* primitive = find_primitive(document, id);
  const Json* targets = primitive == nullptr ? nullptr : array_field(*primitive, "targets");
  std::vector<MorphAttribute> morphs;
  uint64_t unbacked_bytes = 0;
  for (size_t t = 0; targets != nullptr && t < targets->size(); ++t) {
    if (!(*targets)[t].is_object()) return invalid_input("a morph target is not an object", place_of(id));
    for (const auto& [semantic, index] : (*targets)[t].items()) {
      const auto number = integer_value(index);
      if (!number) return invalid_input("morph target " + semantic + " has no accessor", place_of(id));
      const Json* stated = top_level_object(document.json, "accessors", *number);
      const auto count = stated == nullptr ? std::nullopt : integer_field(*stated, "count");
      if (point_count && count != *point_count)  // before memory is allocated for it
        return invalid_input("morph target " + semantic + " has " + std::to_string(count.value_or(0)) +
                                 " elements for " + std::to_string(*point_count) + " points",
                             place_of(id));
      Expected<AccessorData> data = read_accessor(document, *number);
      if (!data) return data.status().at(place_of(id));
      const Json& accessor = *stated;
      if (field(accessor, "bufferView") == nullptr &&
          (unbacked_bytes += data->values.size()) > kMaxUnbackedBytes)
        return invalid_input("morph targets without a buffer view are too large", place_of(id));
      const bool sparse = field(accessor, "sparse") != nullptr || field(accessor, "bufferView") == nullptr;
      morphs.push_back({t, semantic, std::move(*data), sparse});
    }
  }
  return morphs;
}

Expected<StoredPrimitive> stored_primitive(const Document& document, PrimitiveId id,
                                           const char* extension_name) {
  const Json* primitive = find_primitive(document, id);
  const Json* extension = primitive == nullptr ? nullptr : extension_field(*primitive, extension_name);
  if (extension == nullptr)
    return invalid_input(std::string(extension_name) + " is missing or not an object", place_of(id));
  const auto bytes = extension_bytes(document, *extension);
  if (!bytes) return bytes.status().at(place_of(id));
  auto requests = requests_of(document, *primitive, *extension);
  if (!requests) return requests.status().at(place_of(id));
  return StoredPrimitive{*bytes, std::move(*requests)};
}

}  // namespace psplit
