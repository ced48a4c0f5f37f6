#include "tools/gltf_psplit/sameness/placed_meshes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "gltf_ext/compare/elements.h"
#include "tools/gltf_psplit/preview/scene.h"

namespace psplit {
namespace {

// A small file can repeat its meshes often and so use much memory. The limit is kMostRepeats times the points
// and faces of the file, plus kSparePoints.
constexpr uint64_t kMostRepeats = 64, kSparePoints = 5'000'000;
constexpr double kRounding = 1e-6;  // relative error of a sum of four floats

double determinant(const Transform& transform) { return dot(cross(transform.x, transform.y), transform.z); }

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
double rounding_of(const Attribute& attribute) {
  if (attribute.component_type == ComponentType::kFloat32) return 0;
  const size_t bits = 8 * component_bytes(attribute.component_type);
  const bool is_signed =
      attribute.component_type == ComponentType::kInt8 || attribute.component_type == ComponentType::kInt16;
  return attribute.normalized ? 0.5 / (std::ldexp(1.0, static_cast<int>(bits) - (is_signed ? 1 : 0)) - 1) : 0.5;
}

// Maps the first three components of each value. A fourth component is multiplied by `last`.
template <typename Map>
Attribute mapped(const Attribute& attribute, uint32_t point_count, const Map& map, double last) {
  Attribute result{attribute.semantic, ComponentType::kFloat32, attribute.component_count, false, {}};
  result.values.resize(point_count * result.stride());
  for (uint32_t point = 0; point < point_count; ++point) {
    const Vec3 to =
        map({number_at(attribute, point, 0), number_at(attribute, point, 1), number_at(attribute, point, 2)});
    std::array<float, 4> values{static_cast<float>(to.x), static_cast<float>(to.y), static_cast<float>(to.z),
                                0};
    if (attribute.component_count == 4) values[3] = static_cast<float>(number_at(attribute, point, 3) * last);
    std::memcpy(result.values.data() + point * result.stride(), values.data(), result.stride());
  }
  return result;
}

Vec3 unit(Vec3 v) {
  const double size = length(v);
  return size > 0 ? v * (1 / size) : v;
}

void place(AssetPrimitive& primitive, const Transform& transform) {
  const bool mirrors = determinant(transform) < 0;
  const double sign = mirrors ? -1 : 1;
  const auto [shortest, longest] = axes(transform);
  std::erase_if(primitive.mesh.attributes,
                [](const Attribute& attribute) { return attribute.semantic.starts_with("target "); });
  for (Attribute& attribute : primitive.mesh.attributes) {
    const std::string& name = attribute.semantic;
    if ((name != "POSITION" && name != "NORMAL" && name != "TANGENT") || attribute.component_count < 3)
      continue;
    DeclaredGrid grid = primitive.grids.contains(name) ? primitive.grids[name]
                                                       : DeclaredGrid{rounding_of(attribute), false, ""};
    grid.identity.clear();
    if (name == "POSITION") {
      double farthest = 0;
      attribute = mapped(
          attribute, primitive.mesh.point_count,
          [&](Vec3 p) {
            const Vec3 to = transform.point(p);
            farthest = std::max({farthest, std::fabs(to.x), std::fabs(to.y), std::fabs(to.z)});
            return to;
          },
          1);
      grid.within = grid.within * stretch(transform) + kRounding * farthest;
    } else {
      const bool is_normal = name == "NORMAL";
      attribute = mapped(
          attribute, primitive.mesh.point_count,
          [&](Vec3 d) { return unit(is_normal ? transform.normal(d) * sign : transform.direction(d)); }, sign);
      // The corner of a cube is farther from its centre than its sides are. A stretched direction turns by a
      // larger angle.
      grid.within =
          grid.within * (grid.direction ? 1 : std::sqrt(3.0)) * (shortest > 0 ? longest / shortest : 1) +
          kRounding;
      grid.direction = true;
    }
    primitive.grids[name] = grid;
  }
  if (mirrors && primitive.corner_count == 3)
    for (auto& face : primitive.mesh.faces) std::swap(face[1], face[2]);
}

}  // namespace

Expected<AssetMeshes> place_meshes(const Document& document, const AssetMeshes& asset) {
  const Expected<std::vector<MeshInstance>> instances = scene_instances(document);
  if (!instances) return instances.status();
  std::vector<std::vector<const AssetPrimitive*>> meshes(asset.whole_count);
  for (const AssetPrimitive& primitive : asset.primitives) meshes[primitive.whole].push_back(&primitive);
  AssetMeshes placed;
  placed.whole_count = 1;
  placed.material_count = asset.material_count;
  const auto size_of = [](const AssetPrimitive& primitive) {
    return primitive.mesh.point_count + primitive.mesh.faces.size();
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
      place(copy, instance.to_world);
    }
  return placed;
}

}  // namespace psplit
