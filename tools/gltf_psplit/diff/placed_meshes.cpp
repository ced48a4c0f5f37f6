#include <algorithm>
#include <cmath>
#include <memory>

#include "tools/gltf_psplit/diff/compared_asset.h"
#include "tools/gltf_psplit/diff/elements.h"
#include "tools/gltf_psplit/preview/scene.h"

namespace psplit {
namespace {

// A small file can repeat its meshes often and so use much memory. The limit is kMostRepeats times the points
// and faces of the file, plus kSparePoints.
constexpr uint64_t kMostRepeats = 64, kSparePoints = 5'000'000;
constexpr double kRounding = 1e-6;  // relative error of a sum of four floats

// The lengths of the shortest and of the longest axis.
std::pair<double, double> axes(const Transform& transform) {
  return std::minmax({length(transform.x), length(transform.y), length(transform.z)});
}

// The largest error of a transformed component if each component has an error of at most 1.
double stretch(const Transform& t) {
  return std::max({std::fabs(t.x.x) + std::fabs(t.y.x) + std::fabs(t.z.x),
                   std::fabs(t.x.y) + std::fabs(t.y.y) + std::fabs(t.z.y),
                   std::fabs(t.x.z) + std::fabs(t.y.z) + std::fabs(t.z.z)});
}

// The largest rounding error of values that were converted to this type.
double rounding_of(const ValuesView& values) {
  if (values.component_type == ComponentType::kFloat32) return 0;
  const size_t bits = 8 * component_bytes(values.component_type);
  const bool is_signed =
      values.component_type == ComponentType::kInt8 || values.component_type == ComponentType::kInt16;
  return values.normalized ? 0.5 / (std::ldexp(1.0, static_cast<int>(bits) - (is_signed ? 1 : 0)) - 1) : 0.5;
}

// Maps the first three components of each value. A fourth component is multiplied by `last`.
template <typename Map>
ValuesView mapped(const ValuesView& values, const Map& map, double last, AssetPrimitive& owner) {
  const auto results = std::make_shared<std::vector<float>>();
  results->reserve(size_t{values.count} * values.component_count);
  for (uint32_t point = 0; point < values.count; ++point) {
    const Vec3 to =
        map({number_at(values, point, 0), number_at(values, point, 1), number_at(values, point, 2)});
    for (const double value : {to.x, to.y, to.z}) results->push_back(static_cast<float>(value));
    if (values.component_count == 4) results->push_back(static_cast<float>(number_at(values, point, 3) * last));
  }
  owner.owned.push_back(results);
  return {ComponentType::kFloat32, values.component_count, false, values.count,
          std::as_bytes(std::span<const float>(*results))};
}

void place(AssetPrimitive& primitive, const Transform& transform, const PrecisePosition& origin) {
  const bool mirrored = mirrors(transform);
  primitive.origin = origin;
  const auto [shortest, longest] = axes(transform);
  std::erase_if(primitive.view.attributes,
                [](const MeshView::Values& attribute) { return target_of(attribute.semantic).has_value(); });
  for (MeshView::Values& attribute : primitive.view.attributes) {
    const std::string& name = attribute.semantic;
    ValuesView& values = attribute.values;
    if ((name != "POSITION" && name != "NORMAL" && name != "TANGENT") || values.component_count < 3) continue;
    DeclaredGrid grid =
        primitive.grids.contains(name) ? primitive.grids[name] : DeclaredGrid{rounding_of(values)};
    grid.identity.clear();
    if (name == "POSITION") {
      double farthest = 0;
      values = mapped(
          values,
          [&](Vec3 p) {
            const Vec3 to = moved(transform, mirrored, name, p) - Vec3{origin[0], origin[1], origin[2]};
            farthest = std::max({farthest, std::fabs(to.x), std::fabs(to.y), std::fabs(to.z)});
            return to;
          },
          1, primitive);
      grid.within = grid.within * stretch(transform) + kRounding * farthest;
    } else {
      values = mapped(
          values, [&](Vec3 d) { return moved(transform, mirrored, name, d); }, mirrored ? -1 : 1, primitive);
      // The corner of a cube is farther from its centre than its sides are. A stretched direction turns by a
      // larger angle.
      grid.within = grid.within * (grid.coding.octahedral ? 1 : std::sqrt(3.0)) *
                        (shortest > 0 ? longest / shortest : 1) +
                    kRounding;
      grid.coding.octahedral = true;
    }
    primitive.grids[name] = grid;
  }
  if (!mirrored || primitive.corner_count != 3) return;
  ElementBag bag(3);
  bag.add({primitive.view.indices, {}, {}});
  const auto faces = std::make_shared<std::vector<std::array<uint32_t, 3>>>();
  for (uint32_t i = 0; i < bag.size(); ++i) {
    const auto [a, b, c] = bag.locate(i).points;
    faces->push_back({a, c, b});
  }
  primitive.owned.push_back(faces);
  primitive.view.indices = {ComponentType::kUint32, 1, false, 3 * bag.size(), std::as_bytes(std::span(*faces))};
}

}  // namespace

std::vector<PrecisePosition> mesh_origins(const Document& document) {
  std::vector<PrecisePosition> origins(document.records().meshes.size());
  const Expected<std::vector<MeshInstance>> instances = scene_instances(document);
  if (!instances) return origins;
  std::vector<bool> is_seen(origins.size()), is_moved_otherwise(origins.size());
  for (const MeshInstance& instance : *instances) {
    if (instance.mesh >= origins.size()) continue;
    const Transform& t = instance.to_world;
    const auto is = [](Vec3 v, Vec3 to) { return v.x == to.x && v.y == to.y && v.z == to.z; };
    const PrecisePosition origin{t.origin.x, t.origin.y, t.origin.z};
    if (!is(t.x, {1, 0, 0}) || !is(t.y, {0, 1, 0}) || !is(t.z, {0, 0, 1}) ||
        (is_seen[instance.mesh] && origins[instance.mesh] != origin))
      is_moved_otherwise[instance.mesh] = true;
    is_seen[instance.mesh] = true;
    origins[instance.mesh] = origin;
  }
  for (size_t i = 0; i < origins.size(); ++i)
    if (is_moved_otherwise[i]) origins[i] = {};
  return origins;
}

double half_step(const DeclaredGrid& positions) {
  if (positions.coding.bits == 0) return positions.within;
  return double{positions.coding.range} / (std::ldexp(1.0, positions.coding.bits) - 1) / 2;
}

OriginChoice origin_beside(const ComparedAsset& other) {
  OriginChoice choice;
  const auto is_zero = [](const PrecisePosition& origin) { return origin == PrecisePosition{}; };
  if (!std::ranges::all_of(other.origins, is_zero)) {
    choice.by = OriginChoice::By::kGiven;
    choice.given = other.origins;
    choice.refuses_coarse = true;
  }
  for (const AssetPrimitive& primitive : other.meshes.primitives)
    if (const auto grid = primitive.grids.find("POSITION"); grid != primitive.grids.end())
      choice.spare = std::max(choice.spare, half_step(grid->second));
  return choice;
}

Expected<PositionSpread> spread_of_scene(const Document& document, const AssetMeshes& asset) {
  const Expected<std::vector<MeshInstance>> instances = scene_instances(document);
  if (!instances) return instances.status();
  PositionSpread spread;
  for (const MeshInstance& instance : *instances)
    for (const AssetPrimitive& primitive : asset.primitives) {
      const ValuesView* const values = primitive.view.find("POSITION");
      if (primitive.whole != instance.mesh || values == nullptr || values->component_count < 3) continue;
      for (uint32_t point = 0; point < values->count; ++point) {
        const Vec3 at = instance.to_world.point(
            {number_at(*values, point, 0), number_at(*values, point, 1), number_at(*values, point, 2)});
        if (const PrecisePosition position{at.x, at.y, at.z}; is_finite(position)) spread.add(position);
      }
    }
  return spread;
}

Expected<AssetMeshes> place_meshes(const Document& document, const AssetMeshes& asset,
                                   const PrecisePosition& origin) {
  const Expected<std::vector<MeshInstance>> instances = scene_instances(document);
  if (!instances) return instances.status();
  std::vector<std::vector<const AssetPrimitive*>> meshes(asset.whole_count);
  for (const AssetPrimitive& primitive : asset.primitives) meshes[primitive.whole].push_back(&primitive);
  AssetMeshes placed;
  placed.whole_count = 1;
  placed.material_count = asset.material_count;
  const auto size_of = [](const AssetPrimitive& primitive) {
    return uint64_t{primitive.view.point_count} + primitive.element_count();
  };
  uint64_t own = 0, points = 0;
  for (const AssetPrimitive& primitive : asset.primitives) own += size_of(primitive);
  for (const MeshInstance& instance : *instances)
    for (const AssetPrimitive* primitive : meshes[instance.mesh]) points += size_of(*primitive);
  if (points > kSparePoints + kMostRepeats * own)
    return unsupported("the scene repeats its meshes too often to be compared");
  for (const MeshInstance& instance : *instances)
    for (const AssetPrimitive* primitive : meshes[instance.mesh]) {
      AssetPrimitive& copy = placed.primitives.emplace_back(*primitive);
      copy.whole = 0;
      place(copy, instance.to_world, origin);
    }
  return placed;
}

}  // namespace psplit
