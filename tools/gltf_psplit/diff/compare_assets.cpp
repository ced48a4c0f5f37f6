// Primitives are first compared by their numbers. If that fails, or if the numbers of primitives differ, all
// elements of a mesh with the same attributes and material form one bag: so a mesh that was cut into primitives
// equals the whole.
#include "tools/gltf_psplit/diff/compare_assets.h"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>

#include "tools/gltf_psplit/diff/compare_group.h"
#include "tools/gltf_psplit/diff/elements.h"

namespace psplit {
namespace {

using Primitives = std::vector<const AssetPrimitive*>;

std::vector<Primitives> by_mesh(const AssetMeshes& asset) {
  std::vector<Primitives> meshes(asset.whole_count);
  for (const AssetPrimitive& primitive : asset.primitives)
    if (!primitive.has_no_data) meshes[primitive.whole].push_back(&primitive);
  return meshes;
}

void add(AssetComparison::Counts& sum, const AssetComparison::Counts& counts) {
  sum.alone += counts.alone;
  sum.degenerate_alone += counts.degenerate_alone;
}

void add(AssetComparison& sum, const AssetComparison& part) {
  add(sum.a, part.a);
  add(sum.b, part.b);
  for (const AssetComparison::Values& values : part.values) {
    auto place =
        std::ranges::lower_bound(sum.values, values.attribute, {}, &AssetComparison::Values::attribute);
    if (place == sum.values.end() || place->attribute != values.attribute)
      place = sum.values.insert(place, {values.attribute});
    place->largest = std::max(place->largest, values.largest);
    place->tolerance = std::max(place->tolerance, values.tolerance);
  }
  if (!sum.first) sum.first = part.first;
}

void count_elements(const AssetMeshes& asset, AssetComparison::Counts& counts) {
  counts.primitives = asset.primitives.size();
  for (const AssetPrimitive& primitive : asset.primitives) {
    counts.without_data += primitive.has_no_data ? 1 : 0;
    const uint32_t elements = primitive.element_count();
    (primitive.corner_count == 3   ? counts.triangles
     : primitive.corner_count == 2 ? counts.lines
                                   : counts.points) += elements;
    ElementBag bag(primitive.corner_count);
    bag.add({primitive.view.indices, {}, {}});
    std::vector<bool> used(primitive.view.point_count);
    for (uint32_t i = 0; i < elements; ++i)
      for (const uint32_t point : bag.locate(i).points) used[point] = true;
    bag.release();
    counts.unused_points += static_cast<uint64_t>(std::ranges::count(used, false));
  }
}

class AssetComparer {
 public:
  AssetComparer(const AssetMeshes& a, const AssetMeshes& b, const CompareRules& rules,
                const CompareMeans& means)
      : a_(a), b_(b), rules_(rules), means_(means), by_material_(a.material_count == b.material_count) {}

  Expected<AssetComparison> run() {
    AssetComparison result;
    count_elements(a_, result.a);
    count_elements(b_, result.b);
    if (a_.whole_count != b_.whole_count) {
      result.first.emplace();
      result.first->what = "the files have " + std::to_string(a_.whole_count) + " and " +
                           std::to_string(b_.whole_count) + " meshes";
    }
    if (result.a.without_data != result.b.without_data && !result.first) {
      result.first.emplace();
      result.first->what = "the files have " + std::to_string(result.a.without_data) + " and " +
                           std::to_string(result.b.without_data) + " primitives without data";
    }
    const std::vector<Primitives> meshes_a = by_mesh(a_), meshes_b = by_mesh(b_);
    for (size_t mesh = 0; mesh < std::min(meshes_a.size(), meshes_b.size()); ++mesh) {
      bool recut = false;
      const Expected<AssetComparison> part = compare_mesh(meshes_a[mesh], meshes_b[mesh], recut);
      if (!part) return part.status();
      add(result, *part);
      result.recut_meshes += recut;
    }
    return result;
  }

 private:
  Expected<AssetComparison> compare_mesh(const Primitives& a, const Primitives& b, bool& recut) const {
    AssetComparison by_number;
    if (a.size() == b.size()) {
      for (size_t i = 0; i < a.size(); ++i) {
        const Expected<AssetComparison> part =
            compare_group({&a[i], 1}, {&b[i], 1}, by_material_, rules_, means_);
        if (!part) return part.status();
        add(by_number, *part);
      }
      if (by_number.same() || a.size() == 1) return by_number;
    }
    const Expected<AssetComparison> together = compare_together(a, b);
    if (!together) return together.status();
    recut = together->same();
    return recut || a.size() != b.size() ? *together : by_number;
  }

  Expected<AssetComparison> compare_together(const Primitives& a, const Primitives& b) const {
    std::vector<std::array<Primitives, 2>> groups;
    std::map<std::tuple<int, int64_t, std::vector<std::pair<std::string, int>>>, size_t> numbers;
    for (const size_t side : {0u, 1u})
      for (const AssetPrimitive* primitive : side == 0 ? a : b) {
        const auto [number, is_new] =
            numbers.emplace(std::tuple(primitive->corner_count, by_material_ ? primitive->material : -1,
                                       compared_attributes(*primitive, rules_)),
                            groups.size());
        if (is_new) groups.emplace_back();
        groups[number->second][side].push_back(primitive);
      }
    AssetComparison result;
    for (const auto& [of_a, of_b] : groups) {
      const Expected<AssetComparison> part = compare_group(of_a, of_b, by_material_, rules_, means_);
      if (!part) return part.status();
      add(result, *part);
    }
    return result;
  }

  const AssetMeshes& a_;
  const AssetMeshes& b_;
  const CompareRules& rules_;
  const CompareMeans& means_;
  bool by_material_;
};

}  // namespace

Expected<AssetComparison> compare_assets(const AssetMeshes& a, const AssetMeshes& b, const CompareRules& rules,
                                         const CompareMeans& means) {
  return AssetComparer(a, b, rules, means).run();
}

}  // namespace psplit
