#include "tools/gltf_psplit/preview/scene.h"

#include <array>

#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

constexpr size_t kMostRepeats = 100000;  // for nodes with several parents

// Leaves `values` unchanged if the member is missing.
template <size_t N>
Status read_numbers(const Json& node, const char* name, std::array<double, N>& values) {
  const Json* array = field(node, name);
  if (array == nullptr) return {};
  bool valid = array->is_array() && array->size() == N;
  for (size_t i = 0; valid && i < N; ++i) {
    const auto number = number_value((*array)[i]);
    valid = number.has_value();
    values[i] = number.value_or(0);
  }
  if (valid) return {};
  return invalid_input(std::string(name) + " is not an array of " + std::to_string(N) + " numbers");
}

// glTF 2.0, section 3.5.3: a matrix in column-major order; or a scale, a rotation and a translation, applied in
// this order.
Expected<Transform> node_transform(const Json& node) {
  std::array<double, 16> m{};
  std::array<double, 4> rotation{0, 0, 0, 1};
  std::array<double, 3> t{}, s{1, 1, 1};
  for (const Status& status : {read_numbers(node, "matrix", m), read_numbers(node, "rotation", rotation),
                               read_numbers(node, "translation", t), read_numbers(node, "scale", s)})
    if (!status.ok()) return status;
  if (field(node, "matrix") != nullptr)
    return Transform{{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}, {m[12], m[13], m[14]}};
  const auto [x, y, z, w] = rotation;  // a unit quaternion
  return Transform{Vec3{1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)} * s[0],
                   Vec3{2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)} * s[1],
                   Vec3{2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)} * s[2],
                   {t[0], t[1], t[2]}};
}

}  // namespace

bool mirrors(const Transform& transform) { return dot(cross(transform.x, transform.y), transform.z) < 0; }

Vec3 moved(const Transform& transform, bool mirrored, std::string_view semantic, Vec3 value) {
  if (semantic == "POSITION") return transform.point(value);
  const Vec3 to =
      semantic == "NORMAL" ? transform.normal(value) * (mirrored ? -1.0 : 1.0) : transform.direction(value);
  const double size = length(to);
  return size > 0 ? to * (1 / size) : to;
}

Transform operator*(const Transform& outer, const Transform& inner) {
  return {outer.direction(inner.x), outer.direction(inner.y), outer.direction(inner.z),
          outer.point(inner.origin)};
}

Expected<std::vector<MeshInstance>> scene_instances(const Document& document) {
  const Json& json = document.json();
  const size_t mesh_count = array_size(json, "meshes");
  std::vector<MeshInstance> instances;
  if (array_size(json, "scenes") == 0) {
    for (size_t mesh = 0; mesh < mesh_count; ++mesh) instances.push_back({mesh, {}});
    return instances;
  }

  struct Visit {
    const Json* index;
    Transform parent;
  };
  std::vector<Visit> stack;
  // glTF requires trees, but there are assets whose nodes have several parents. A scene with more visits than
  // this has a cycle, or is practically endless.
  size_t visits_left = array_size(json, "nodes") + kMostRepeats;
  const auto push_all = [&](const Json* indices, const Transform& parent) {
    if (indices == nullptr) return true;
    if (indices->size() > visits_left) return false;
    visits_left -= indices->size();
    for (auto index = indices->rbegin(); index != indices->rend(); ++index) stack.push_back({&*index, parent});
    return true;
  };
  const Json* scene = top_level_object(json, "scenes", integer_field_or(json, "scene", 0).value_or(-1));
  if (scene == nullptr) return invalid_input("the default scene does not exist");
  bool finite = push_all(array_field(*scene, "nodes"), {});
  while (finite && !stack.empty()) {
    const auto [index, parent] = stack.back();
    stack.pop_back();
    const auto number = integer_value(*index);
    const Json* node = top_level_object(json, "nodes", number.value_or(-1));
    if (node == nullptr) return invalid_input("the scene names a node that does not exist");
    const std::string name = "node " + std::to_string(*number);
    const Expected<Transform> local = node_transform(*node);
    if (!local) return invalid_input(name + ": " + local.status().message());
    const Transform to_world = parent * *local;
    finite = push_all(array_field(*node, "children"), to_world);
    if (field(*node, "mesh") == nullptr) continue;
    const auto mesh = integer_field(*node, "mesh");
    if (!mesh || *mesh < 0 || static_cast<size_t>(*mesh) >= mesh_count)
      return invalid_input(name + " has a mesh that does not exist");
    instances.push_back({static_cast<size_t>(*mesh), to_world});
  }
  if (!finite) return invalid_input("nodes of the scene are their own descendants, or are repeated too often");
  return instances;
}

}  // namespace psplit
