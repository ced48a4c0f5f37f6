#include "tools/gltf_psplit/diff/read_asset_meshes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "encoder/coding/grid_places.h"
#include "encoder/coding/quantization.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/primitive/describe_primitive.h"
#include "tools/gltf_psplit/diff/filtered_grids.h"

namespace psplit {
namespace {

DeclaredGrid grid_of(const StreamAttribute& attribute) {
  DeclaredGrid grid;
  grid.coding = {attribute.bits, attribute.origin.empty(), attribute.origin, attribute.range};
  for (const double bound : error_bounds(grid.coding))
    if (std::isfinite(bound)) grid.within = std::max(grid.within, bound);
  grid.identity = std::to_string(attribute.bits);
  if (grid.coding.octahedral) return grid;
  for (const float number : attribute.origin)
    grid.identity.append(reinterpret_cast<const char*>(&number), sizeof number);
  grid.identity.append(reinterpret_cast<const char*>(&attribute.range), sizeof attribute.range);
  return grid;
}

// The grids of the quantized attributes of a compressed primitive, by semantic, as its streams state them.
// Empty for a plain primitive. Errors: as for `describe`, kInvalidInput.
Expected<std::map<std::string, DeclaredGrid>> declared_grids(const Document& document, PrimitiveId id,
                                                             const DescribeStream& describe,
                                                             const ThreadPool& pool) {
  std::map<std::string, DeclaredGrid> grids;
  if (document.records().primitive(id).storage() == PrimitiveStorage::kPlain) return grids;
  const Expected<DescribedPrimitive> described = describe_primitive(document, id, describe, pool);
  if (!described) return described.status();
  // The patches that psplit writes share their grids. Patches of other encoders may not.
  for (const StreamDescription& stream : described->streams) {
    for (const AttributeRequest& request : described->requests) {
      const auto& attributes = stream.attributes;
      const auto found = std::ranges::find(attributes, request.unique_id, &StreamAttribute::unique_id);
      if (found == attributes.end() || found->bits == 0) continue;
      DeclaredGrid grid = grid_of(*found);
      const auto [first, is_new] = grids.emplace(request.semantic, grid);
      if (is_new) continue;
      first->second.within = std::max(first->second.within, grid.within);
      first->second.coding.octahedral |= grid.coding.octahedral;
      if (first->second.identity != grid.identity) first->second.identity.clear();
    }
  }
  return grids;
}

Status add_morph_targets(const Document& document, AssetPrimitive& primitive) {
  if (primitive.has_no_data) return {};
  Expected<std::vector<MorphAttribute>> morphs =
      read_morph_targets(document, primitive.id, primitive.view.point_count);
  if (!morphs) return morphs.status();
  for (MorphAttribute& morph : *morphs) {
    const auto data = std::make_shared<const AccessorData>(std::move(morph.data));
    primitive.view.attributes.push_back({name_of_target(morph.target, morph.semantic), *data});
    primitive.owned.push_back(data);
  }
  return {};
}

// Whether all positions are on the grid.
bool are_on_grid(const ValuesView& positions, const AttributeCoding& grid) {
  if (positions.component_type != ComponentType::kFloat32 || positions.component_count != grid.origin.size())
    return false;
  std::vector<float> value(positions.component_count), rounded;
  return for_each_step(positions, [&](size_t first, size_t end) {
    for (size_t point = first; point < end; ++point) {
      std::memcpy(value.data(), positions.at(point), positions.value_bytes());
      if (!std::ranges::all_of(value, [](float component) { return std::isfinite(component); })) return false;
      rounded = value;
      round_to_grid(rounded, grid);
      if (rounded != value) return false;
    }
    return true;
  });
}

// The encoder rounds primitives that stay plain to the grid of those beside them. Such positions have this
// grid, too: of their mesh, or of the whole asset if that has one.
void find_grids_of_plain(AssetMeshes& asset) {
  constexpr size_t kAsset = SIZE_MAX;
  std::map<size_t, const DeclaredGrid*> grids;  // of meshes; null: several
  for (const AssetPrimitive& primitive : asset.primitives) {
    const auto found = primitive.grids.find("POSITION");
    if (found == primitive.grids.end()) continue;
    const DeclaredGrid* const grid = found->second.identity.empty() ? nullptr : &found->second;
    for (const size_t whole : {primitive.whole, kAsset}) {
      const auto [first, is_new] = grids.emplace(whole, grid);
      const bool is_same =
          grid != nullptr && first->second != nullptr && first->second->identity == grid->identity;
      if (!is_new && !is_same) first->second = nullptr;
    }
  }
  for (AssetPrimitive& primitive : asset.primitives) {
    if (primitive.has_no_data || primitive.grids.contains("POSITION")) continue;
    const ValuesView* const positions = primitive.view.find("POSITION");
    const auto own = grids.find(primitive.whole), all = grids.find(kAsset);
    const DeclaredGrid* const grid = own != grids.end()   ? own->second
                                     : all != grids.end() ? all->second
                                                          : nullptr;
    if (positions == nullptr || grid == nullptr || !are_on_grid(*positions, grid->coding)) continue;
    primitive.grids.emplace("POSITION", DeclaredGrid(*grid));
  }
}

// Only what has no grid of streams, or of primitives beside it.
void add_filtered_grids(const Document& document, AssetMeshes& asset) {
  FilteredGrids filtered(document);
  for (AssetPrimitive& primitive : asset.primitives) {
    if (primitive.has_no_data) continue;
    const auto add = [&](const std::string& name, int64_t accessor) {
      if (primitive.grids.contains(name)) return;
      if (std::optional<DeclaredGrid> grid = filtered.of(accessor))
        primitive.grids.emplace(name, std::move(*grid));
    };
    const PrimitiveRecord& record = document.records().primitive(primitive.id);
    for (const AttributeRecord& attribute : record.attributes) add(attribute.semantic, attribute.accessor);
    for (size_t t = 0; t < record.targets.size(); ++t)
      for (const AttributeRecord& attribute : record.targets[t])
        add(name_of_target(t, attribute.semantic), attribute.accessor);
  }
}

// Whether attributes or indices are in a buffer without bytes.
bool has_no_data(const Document& document, const PrimitiveRecord& primitive) {
  const auto is_missing = [&](int64_t index) {
    const int64_t view = index < 0 ? -1 : document.records().accessor(index).elements.view;
    return view >= 0 && has_no_bytes(document, static_cast<size_t>(document.records().view(view).range.buffer));
  };
  return is_missing(primitive.indices) ||
         std::ranges::any_of(primitive.attributes, is_missing, &AttributeRecord::accessor);
}

}  // namespace

void AssetPrimitive::take(Mesh mesh) {
  const auto kept = std::make_shared<const Mesh>(std::move(mesh));
  view = view_of(*kept);
  owned = {kept};
}

void AssetPrimitive::set_origin(const std::array<double, 3>& to) {
  origin = to;
  const auto grid = grids.find("POSITION");
  if (origin == std::array<double, 3>{} || grid == grids.end() || grid->second.identity.empty()) return;
  grid->second.identity.append(reinterpret_cast<const char*>(origin.data()), sizeof origin);
}

Expected<AssetMeshes> read_asset_meshes(const Document& document, const DecodeBackend& backend,
                                        const DescribeStream& describe, const ThreadPool& pool,
                                        const Progress& progress, const ViewPrimitive& view) {
  AssetMeshes asset;
  asset.whole_count = document.records().meshes.size();
  asset.material_count = array_size(document.json(), "materials");
  std::vector<PrimitiveId> ids;
  std::vector<size_t> places;
  for (const PrimitiveId id : all_primitives(document)) {
    const PrimitiveRecord& record = document.records().primitive(id);
    if (!record.status.ok()) return record.status;
    AssetPrimitive& primitive = asset.primitives.emplace_back();
    primitive.id = id;
    primitive.whole = id.mesh;
    primitive.material = record.material;
    primitive.has_no_data = record.storage() == PrimitiveStorage::kPlain && has_no_data(document, record);
    if (primitive.has_no_data) continue;
    if (!record.has_triangles()) {
      Expected<LinesOrPoints> elements = read_lines_or_points(document, id);
      if (!elements) return elements.status();
      primitive.corner_count = elements->corner_count;
      primitive.take(std::move(elements->mesh));
      continue;
    }
    const Expected<bool> is_viewed = view ? view(primitive) : false;
    if (!is_viewed) return is_viewed.status().at(place_of(id));
    if (*is_viewed) continue;
    ids.push_back(id);
    places.push_back(asset.primitives.size() - 1);
  }
  std::vector<Expected<Mesh>> meshes = read_primitives(document, ids, backend, pool, progress);
  for (size_t i = 0; i < ids.size(); ++i) {
    if (!meshes[i]) return meshes[i].status();
    if (meshes[i]->faces.size() > UINT32_MAX / 3)
      return unsupported("has more triangles than can be compared", place_of(ids[i]));
    asset.primitives[places[i]].take(std::move(*meshes[i]));
  }
  for (AssetPrimitive& primitive : asset.primitives) {
    if (primitive.corner_count == 3 && !primitive.has_no_data) {
      Expected<std::map<std::string, DeclaredGrid>> grids =
          declared_grids(document, primitive.id, describe, pool);
      if (!grids) return grids.status().at(place_of(primitive.id));
      primitive.grids = std::move(*grids);
    }
    if (Status status = add_morph_targets(document, primitive); !status.ok())
      return std::move(status).at(place_of(primitive.id));
  }
  find_grids_of_plain(asset);
  add_filtered_grids(document, asset);
  return asset;
}

}  // namespace psplit
