#include "gltf_ext/primitive/read_primitives.h"

#include <algorithm>
#include <vector>

#include "gltf_ext/primitive/view_in_place.h"
#include "src/container/patch_container.h"

namespace psplit {
namespace {

constexpr size_t kIndicesAtOnce = 3 << 16;

Expected<Attribute> read_attribute(const Document& document, const AttributeRecord& attribute) {
  Expected<AccessorData> data = read_accessor(document, attribute.accessor);
  if (!data)
    return Status(data.status().code(), "attribute " + attribute.semantic + ": " + data.status().message());
  return Attribute{attribute.semantic, data->component_type, data->component_count, data->normalized,
                   std::move(data->values)};
}

// Reads the attributes that the mesh does not have yet from their accessors.
Status read_plain_attributes(const Document& document, const PrimitiveRecord& primitive, Mesh& mesh) {
  bool first = mesh.attributes.empty();
  for (const AttributeRecord& attribute : primitive.attributes) {
    if (mesh.find(attribute.semantic) != nullptr) continue;
    if (target_of(attribute.semantic))
      return unsupported("attribute " + attribute.semantic + " has a name that glTF does not allow");
    const uint32_t count = document.records().accessor(attribute.accessor).count;
    if (!first && count != mesh.point_count)  // before memory is allocated for it
      return invalid_input("attribute " + attribute.semantic + " has " + std::to_string(count) +
                           " elements, others have " + std::to_string(mesh.point_count));
    Expected<Attribute> values = read_attribute(document, attribute);
    if (!values) return values.status();
    mesh.point_count = count;
    first = false;
    mesh.attributes.push_back(std::move(*values));
  }
  if (mesh.find("POSITION") == nullptr) return unsupported("no POSITION");
  return {};
}

// The indices of a primitive. `make_room(count)` returns the memory for them, or an error.
template <typename MakeRoom>
Status read_indices_of(const Document& document, const PrimitiveRecord& primitive, uint32_t point_count,
                       const ThreadPool& pool, MakeRoom make_room) {
  ValuesView indices{ComponentType::kUint32, 1, false, point_count, {}, 0};
  AccessorData copy;
  if (primitive.indices >= 0) {
    const Expected<ValuesView> view = accessor_view(document, primitive.indices);
    if (view) {
      indices = *view;
    } else {
      Expected<AccessorData> data = read_accessor(document, primitive.indices);
      if (!data) return data.status();
      copy = std::move(*data);
      indices = copy;
    }
    if (indices.component_count != 1 ||
        (indices.component_type != ComponentType::kUint8 && indices.component_type != ComponentType::kUint16 &&
         indices.component_type != ComponentType::kUint32))
      return invalid_input("indices are not unsigned scalars");
  }
  const Expected<std::span<uint32_t>> room = make_room(size_t{indices.count});
  if (!room) return room.status();
  std::vector<Status> statuses((room->size() + kIndicesAtOnce - 1) / kIndicesAtOnce);
  pool.for_ranges(room->size(), kIndicesAtOnce, [&](size_t begin, size_t end) {
    statuses[begin / kIndicesAtOnce] =
        read_indices(indices, begin, point_count, room->subspan(begin, end - begin));
  });
  const auto failed = std::ranges::find_if(statuses, [](const Status& status) { return !status.ok(); });
  return failed == statuses.end() ? Status() : std::move(*failed);
}

Expected<std::vector<uint32_t>> indices_of(const Document& document, const PrimitiveRecord& primitive,
                                           uint32_t point_count, const ThreadPool& pool) {
  std::vector<uint32_t> indices;
  Status status = read_indices_of(document, primitive, point_count, pool,
                                  [&](size_t count) -> Expected<std::span<uint32_t>> {
                                    indices.resize(count);
                                    return std::span(indices);
                                  });
  if (!status.ok()) return status;
  return indices;
}

// Triangles of a list, strip or fan, with the orientation that glTF defines.
Expected<Array<std::array<uint32_t, 3>>> triangles_of(const Document& document,
                                                      const PrimitiveRecord& primitive, uint32_t point_count,
                                                      const ThreadPool& pool) {
  Array<std::array<uint32_t, 3>> faces;
  const int mode = primitive.mode;
  if (mode == 4) {
    Status status = read_indices_of(
        document, primitive, point_count, pool, [&](size_t count) -> Expected<std::span<uint32_t>> {
          if (count % 3 != 0) return invalid_input("a triangle list has " + std::to_string(count) + " indices");
          faces.resize(count / 3);
          return std::span(faces.empty() ? nullptr : faces.front().data(), count);
        });
    if (!status.ok()) return status;
    return faces;
  }
  const Expected<std::vector<uint32_t>> read = indices_of(document, primitive, point_count, pool);
  if (!read) return read.status();
  const std::vector<uint32_t>& indices = *read;
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
Expected<Mesh> read_plain(const Document& document, const PrimitiveRecord& primitive, const ThreadPool& pool,
                          Mesh mesh) {
  if (Status status = read_plain_attributes(document, primitive, mesh); !status.ok()) return status;
  if (primitive.storage() == PrimitiveStorage::kStockDraco && primitive.indices >= 0 &&
      document.records().accessor(primitive.indices).layout.component_count() != 1)
    return invalid_input("indices are not scalars");
  if (primitive.storage() != PrimitiveStorage::kPlain) return mesh;
  auto faces = triangles_of(document, primitive, mesh.point_count, pool);
  if (!faces) return faces.status();
  mesh.faces = std::move(*faces);
  return mesh;
}

// Opens the data of a primitive that has triangles; nothing if it is plain.
Expected<std::optional<PatchContainer>> open_stored(const Document& document, PrimitiveId id,
                                                    StoredPrimitive& stored) {
  const PrimitiveRecord& primitive = document.records().primitive(id);
  if (!primitive.status.ok()) return primitive.status;
  if (!primitive.has_triangles())
    return unsupported("mode " + std::to_string(primitive.mode) + " has no triangles");
  if (primitive.storage() == PrimitiveStorage::kPlain) return std::optional<PatchContainer>();
  Expected<StoredPrimitive> read = stored_primitive(document, id);
  if (!read) return read.status();
  stored = std::move(*read);
  Expected<PatchContainer> container = primitive.storage() == PrimitiveStorage::kPatches
                                           ? open_container(stored.bytes)
                                           : open_stream(stored.bytes);
  if (!container) return container.status();
  return std::optional(std::move(*container));
}

}  // namespace

Expected<Mesh> read_primitive(const Document& document, PrimitiveId id, const DecodeBackend& backend,
                              const ThreadPool& pool) {
  return std::move(read_primitives(document, {&id, 1}, backend, pool).front());
}

std::vector<Expected<Mesh>> read_primitives(const Document& document, std::span<const PrimitiveId> ids,
                                            const DecodeBackend& backend, const ThreadPool& pool,
                                            const Progress& progress) {
  std::vector<Expected<Mesh>> meshes(ids.size(), Mesh());
  std::vector<StoredPrimitive> stored;
  std::vector<PatchContainer> containers;
  std::vector<size_t> decoded;  // indices into `ids`
  for (size_t i = 0; i < ids.size(); ++i) {
    StoredPrimitive primitive;
    Expected<std::optional<PatchContainer>> container = open_stored(document, ids[i], primitive);
    if (!container) meshes[i] = container.status();
    if (!container || !*container) continue;
    stored.push_back(std::move(primitive));
    containers.push_back(std::move(**container));
    decoded.push_back(i);
  }
  std::vector<DecodeTask> tasks;
  for (size_t n = 0; n < stored.size(); ++n) tasks.push_back({&containers[n], stored[n].requests});
  if (!tasks.empty()) {
    std::vector<Expected<Mesh>> results = backend.decode(tasks, pool, progress);
    for (size_t n = 0; n < tasks.size(); ++n) meshes[decoded[n]] = std::move(results[n]);
  }
  pool.for_each(ids.size(), [&](size_t i) {
    if (meshes[i])
      meshes[i] = read_plain(document, document.records().primitive(ids[i]), pool, std::move(*meshes[i]));
    if (!meshes[i]) meshes[i] = meshes[i].status().at(place_of(ids[i])).at({.file = document.source.string()});
  });
  return meshes;
}

Expected<LinesOrPoints> read_lines_or_points(const Document& document, PrimitiveId id) {
  const PrimitiveRecord& primitive = document.records().primitive(id);
  const int mode = primitive.mode;
  if (mode < 0 || mode > 3) return unsupported("has neither lines nor points", place_of(id));
  LinesOrPoints result;
  result.corner_count = mode == 0 ? 1 : 2;
  if (Status status = read_plain_attributes(document, primitive, result.mesh); !status.ok())
    return std::move(status).at(place_of(id));
  const auto indices = indices_of(document, primitive, result.mesh.point_count, ThreadPool(1));
  if (!indices) return indices.status().at(place_of(id));
  const size_t count = indices->size();
  if (mode == 0)
    for (const uint32_t point : *indices) result.mesh.faces.push_back({point, point, point});
  else
    for (size_t i = 1; i < count; i += mode == 1 ? 2 : 1)
      result.mesh.faces.push_back({(*indices)[i - 1], (*indices)[i], (*indices)[i]});
  if (mode == 2 && count > 2)
    result.mesh.faces.push_back({indices->back(), indices->front(), indices->front()});
  return result;
}

Expected<std::vector<MorphAttribute>> read_morph_targets(const Document& document, PrimitiveId id,
                                                         std::optional<uint32_t> point_count) {
  const AssetRecords& records = document.records();
  const PrimitiveRecord& primitive = records.primitive(id);
  const std::vector<AttributeRecords>& targets = primitive.targets;
  const auto is_in_container = [&](size_t target, const std::string& semantic) {
    return primitive.patches && primitive.patches->stores(name_of_target(target, semantic));
  };
  uint64_t unbacked_bytes = 0;  // before memory is allocated for any
  for (size_t t = 0; t < targets.size(); ++t)
    for (const auto& [semantic, index] : targets[t]) {
      if (is_in_container(t, semantic)) continue;
      const AccessorRecord& accessor = records.accessor(index);
      if (point_count && accessor.count != *point_count)
        return invalid_input("morph target " + semantic + " has " + std::to_string(accessor.count) +
                                 " elements for " + std::to_string(*point_count) + " points",
                             place_of(id));
      if (!accessor.has_view() && (unbacked_bytes += accessor.packed_bytes()) > kMaxUnbackedBytes)
        return invalid_input("morph targets without a buffer view are too large", place_of(id));
    }
  std::vector<MorphAttribute> morphs;
  for (size_t t = 0; t < targets.size(); ++t)
    for (const auto& [semantic, index] : targets[t]) {
      if (is_in_container(t, semantic)) continue;
      const AccessorRecord& accessor = records.accessor(index);
      Expected<AccessorData> data = read_accessor(document, index);
      if (!data) return data.status().at(place_of(id));
      morphs.push_back({t, semantic, std::move(*data), accessor.sparse || !accessor.has_view()});
    }
  return morphs;
}

std::vector<MorphAttribute> take_targets(Mesh& mesh) {
  std::vector<MorphAttribute> morphs;
  for (Attribute& a : mesh.attributes)
    if (auto target = target_of(a.semantic))
      morphs.push_back(
          {target->number,
           std::move(target->semantic),
           {a.component_type, a.component_count, a.normalized, mesh.point_count, std::move(a.values)}});
  std::erase_if(mesh.attributes, [](const Attribute& a) { return target_of(a.semantic).has_value(); });
  return morphs;
}

Attribute attribute_of(MorphAttribute morph) {
  AccessorData& data = morph.data;
  return {name_of_target(morph.target, morph.semantic), data.component_type, data.component_count,
          data.normalized, std::move(data.values)};
}

Expected<StoredPrimitive> stored_primitive(const Document& document, PrimitiveId id) {
  const DracoRecord* draco = document.records().primitive(id).draco();
  if (draco == nullptr) return invalid_input("is not compressed", place_of(id));
  if (!draco->status.ok()) return Status(draco->status).at(place_of(id));
  const auto bytes = buffer_view_bytes(document, draco->view);
  if (!bytes) return bytes.status().at(place_of(id));
  return StoredPrimitive{*bytes, draco->requests};
}

}  // namespace psplit
