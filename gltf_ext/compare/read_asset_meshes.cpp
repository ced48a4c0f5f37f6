#include "gltf_ext/compare/read_asset_meshes.h"

#include <algorithm>

#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

Status add_morph_targets(const Document& document, AssetPrimitive& primitive) {
  if (primitive.has_no_data) return {};
  Expected<std::vector<MorphAttribute>> morphs =
      read_morph_targets(document, primitive.id, primitive.mesh.point_count);
  if (!morphs) return morphs.status();
  for (MorphAttribute& morph : *morphs) {
    if (morph.data.count != primitive.mesh.point_count)
      return invalid_input("a morph target of another point count");
    primitive.mesh.attributes.push_back({"target " + std::to_string(morph.target) + " " + morph.semantic,
                                         morph.data.component_type, morph.data.component_count,
                                         morph.data.normalized, std::move(morph.data.values)});
  }
  return {};
}

// Whether attributes or indices are in a buffer without bytes.
bool has_no_data(const Document& document, PrimitiveId id) {
  const Json& primitive = document.json["meshes"][id.mesh]["primitives"][id.primitive];
  const auto is_missing = [&](const Json& index) {
    const Json* accessor = top_level_object(document.json, "accessors", integer_value(index).value_or(-1));
    if (accessor == nullptr) return false;
    const Json* view = top_level_object(document.json, "bufferViews",
                                        integer_field_or(*accessor, "bufferView", -1).value_or(-1));
    const auto buffer = view == nullptr ? std::nullopt : integer_field(*view, "buffer");
    return buffer && *buffer >= 0 && static_cast<uint64_t>(*buffer) < document.buffers.size() &&
           has_no_bytes(document, static_cast<size_t>(*buffer));
  };
  const Json* attributes = object_field(primitive, "attributes");
  if (attributes != nullptr && std::ranges::any_of(*attributes, is_missing)) return true;
  const Json* indices = field(primitive, "indices");
  return indices != nullptr && is_missing(*indices);
}

}  // namespace

Expected<AssetMeshes> read_asset_meshes(const Document& document, const DecodeBackend& backend,
                                        const DescribeStream& describe, const ThreadPool& pool,
                                        const Progress& progress) {
  AssetMeshes asset;
  asset.whole_count = array_size(document.json, "meshes");
  asset.material_count = array_size(document.json, "materials");
  std::vector<PrimitiveId> ids;
  std::vector<size_t> places;
  for (const PrimitiveId id : all_primitives(document)) {
    const Expected<PrimitiveKind> kind = primitive_kind(document, id);
    if (!kind) return kind.status();
    AssetPrimitive& primitive = asset.primitives.emplace_back();
    primitive.id = id;
    primitive.whole = id.mesh;
    const Json* mesh = top_level_object(document.json, "meshes", static_cast<int64_t>(id.mesh));
    primitive.material = integer_field_or((*mesh)["primitives"][id.primitive], "material", -1).value_or(-1);
    primitive.has_no_data = kind->storage == PrimitiveStorage::kPlain && has_no_data(document, id);
    if (primitive.has_no_data) continue;
    if (kind->triangles) {
      ids.push_back(id);
      places.push_back(asset.primitives.size() - 1);
      continue;
    }
    Expected<LinesOrPoints> elements = read_lines_or_points(document, id);
    if (!elements) return elements.status();
    primitive.corner_count = elements->corner_count;
    primitive.mesh = std::move(elements->mesh);
  }
  std::vector<Expected<Mesh>> meshes = read_primitives(document, ids, backend, pool, progress);
  for (size_t i = 0; i < ids.size(); ++i) {
    AssetPrimitive& primitive = asset.primitives[places[i]];
    if (!meshes[i]) return meshes[i].status();
    primitive.mesh = std::move(*meshes[i]);
    Expected<std::map<std::string, DeclaredGrid>> grids = declared_grids(document, ids[i], describe, pool);
    if (!grids)
      return grids.status().at(
          {.mesh = static_cast<int64_t>(ids[i].mesh), .primitive = static_cast<int64_t>(ids[i].primitive)});
    primitive.grids = std::move(*grids);
  }
  for (AssetPrimitive& primitive : asset.primitives)
    if (Status status = add_morph_targets(document, primitive); !status.ok())
      return std::move(status).at({.mesh = static_cast<int64_t>(primitive.id.mesh),
                                   .primitive = static_cast<int64_t>(primitive.id.primitive)});
  return asset;
}

}  // namespace psplit
