#include "gltf_ext/convert/scene_offsets.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "gltf_ext/document/references.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

using NodePath = std::vector<int64_t>;  // from a root to a mesh

// The paths to the placed meshes. Nothing if nodes are repeated too often, as in a cycle.
std::optional<std::vector<NodePath>> paths_to(const Json& json, const std::set<size_t>& meshes) {
  constexpr size_t kMostNodes = 100000;
  std::vector<NodePath> paths, left;
  for_each_element(json, "scenes", [&](const Json& scene) {
    for_each_element(scene, "nodes",
                     [&](const Json& index) { left.push_back({integer_value(index).value_or(-1)}); });
  });
  for (size_t visits = 0; !left.empty(); ++visits) {
    if (visits > array_size(json, "nodes") + kMostNodes) return std::nullopt;
    const NodePath path = std::move(left.back());
    left.pop_back();
    const Json* node = top_level_object(json, "nodes", path.back());
    if (node == nullptr || path.size() > kMostNodes) return std::nullopt;
    const auto mesh = integer_field(*node, "mesh");
    if (mesh && meshes.contains(static_cast<size_t>(*mesh)) && field(*node, "skin") == nullptr)
      paths.push_back(path);
    for_each_element(*node, "children", [&](const Json& index) {
      left.push_back(path);
      left.back().push_back(integer_value(index).value_or(-1));
    });
  }
  return paths;
}

// The sum of the translations of nodes; nothing if one of them does more.
std::optional<std::array<double, 3>> translation_of(const Json& json, std::span<const int64_t> nodes) {
  std::array<double, 3> sum{};
  for (const int64_t index : nodes) {
    const Json& node = *top_level_object(json, "nodes", index);
    if (field(node, "matrix") != nullptr || extension_field(node, "EXT_mesh_gpu_instancing") != nullptr)
      return std::nullopt;
    const auto is = [&](const char* name, const Json& neutral) {
      const Json* value = field(node, name);
      return value == nullptr || *value == neutral;
    };
    if (!is("rotation", {0, 0, 0, 1}) || !is("scale", {1, 1, 1})) return std::nullopt;
    const Json* translation = array_field(node, "translation");
    if (translation == nullptr) continue;
    for (size_t c = 0; c < 3 && c < translation->size(); ++c)
      sum[c] += number_value((*translation)[c]).value_or(0);
  }
  return sum;
}

}  // namespace

SceneOffsets scene_offsets(const Json& json, const std::set<size_t>& meshes) {
  const auto paths = paths_to(json, meshes);
  if (!paths) return {false, {}};
  if (paths->size() < 2) return {};
  size_t common = paths->front().size();
  for (const NodePath& path : *paths) {
    const auto differs = std::ranges::mismatch(paths->front(), path).in1;
    common = std::min(common, static_cast<size_t>(differs - paths->front().begin()));
  }
  SceneOffsets result;
  std::optional<std::array<double, 3>> first;
  for (const NodePath& path : *paths) {
    const auto moved = translation_of(json, std::span(path).subspan(common));
    if (!moved) return {false, {}};
    if (!first) first = moved;
    const std::array<double, 3> offset{(*moved)[0] - (*first)[0], (*moved)[1] - (*first)[1],
                                       (*moved)[2] - (*first)[2]};
    if (offset != std::array<double, 3>{}) result.offsets.insert(offset);
  }
  return result;
}

}  // namespace psplit
