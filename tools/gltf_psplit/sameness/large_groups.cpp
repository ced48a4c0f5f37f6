#include "tools/gltf_psplit/sameness/large_groups.h"

#include <algorithm>
#include <map>
#include <tuple>

namespace psplit {
namespace {

using Names = std::vector<std::pair<std::string, int>>;

bool has_triangles(const LargeGroup& group) {
  return std::ranges::any_of(group,
                             [](const LargePrimitive* primitive) { return primitive->view.indices.count > 0; });
}

}  // namespace

Names compared_attributes(const LargePrimitive& primitive, const std::vector<std::string>& only) {
  Names names;
  for (const MeshView::Values& attribute : primitive.view.attributes)
    if (only.empty() || attribute.semantic == "POSITION" ||
        std::ranges::find(only, attribute.semantic) != only.end())
      names.emplace_back(attribute.semantic, attribute.values.component_count);
  std::ranges::sort(names, {},
                    [](const auto& name) { return std::pair(name.first != "POSITION", name.first); });
  return names;
}

std::vector<std::array<LargeGroup, 2>> groups_of(const LargeGroup& a, const LargeGroup& b, bool by_material,
                                                 const std::vector<std::string>& only) {
  std::vector<std::array<LargeGroup, 2>> groups;
  std::map<std::pair<int64_t, Names>, size_t> numbers;
  for (size_t side = 0; side < 2; ++side)
    for (const LargePrimitive* primitive : side == 0 ? a : b) {
      const auto [number, is_new] = numbers.emplace(
          std::pair(by_material ? primitive->material : -1, compared_attributes(*primitive, only)),
          groups.size());
      if (is_new) groups.emplace_back();
      groups[number->second][side].push_back(primitive);
    }
  return groups;
}

std::string difference_of_kind(const LargeGroup& a, const LargeGroup& b, bool by_material,
                               const std::vector<std::string>& only) {
  if (a.empty() || b.empty())
    return has_triangles(a) || has_triangles(b)
               ? "a primitive has no counterpart of its attributes and material in the " +
                     std::string(a.empty() ? "first" : "second") + " file"
               : "";
  const Names names_a = compared_attributes(*a[0], only), names_b = compared_attributes(*b[0], only);
  for (const auto& [name, components] : names_a) {
    const auto found = std::ranges::find(names_b, name, &Names::value_type::first);
    if (found == names_b.end()) return "the second file lacks " + name;
    if (found->second != components)
      return name + " has " + std::to_string(components) + " and " + std::to_string(found->second) +
             " components";
  }
  for (const auto& [name, components] : names_b)
    if (std::ranges::find(names_a, name, &Names::value_type::first) == names_a.end())
      return "the first file lacks " + name;
  if (by_material && a[0]->material != b[0]->material)
    return "the materials are " + std::to_string(a[0]->material) + " and " + std::to_string(b[0]->material);
  return "";
}

}  // namespace psplit
