#include "tools/gltf_psplit/commands/character_document.h"

#include <cstring>

#include "gltf_ext/json/json.h"
#include "gltf_ext/primitive/accessors.h"

namespace psplit {
namespace {

template <typename T>
int64_t append_floats(Document& document, const std::vector<T>& values, int target = 0,
                      bool with_bounds = false) {
  AccessorData data{
      ComponentType::kFloat32, sizeof(T) / sizeof(float), false, static_cast<uint32_t>(values.size()), {}};
  data.values.resize(values.size() * sizeof(T));
  std::memcpy(data.values.data(), values.data(), data.values.size());
  return append_accessor(document, data, target, with_bounds);
}

void add_targets(Document& document, const Character& character) {
  Json targets = Json::array(), names = Json::array(), weights = Json::array();
  for (const CharacterTarget& target : character.targets) {
    targets.push_back({{"POSITION", append_floats(document, target.positions, kArrayBuffer, true)},
                       {"NORMAL", append_floats(document, target.normals, kArrayBuffer)}});
    names.push_back(target.name);
    weights.push_back(0);
  }
  Json& mesh = document.json()["meshes"][0];
  mesh["primitives"][0]["targets"] = std::move(targets);
  mesh["weights"] = std::move(weights);
  mesh["extras"] = {{"targetNames", std::move(names)}};
}

// The node of joint j is kFirstJoint + j, after that of the mesh.
constexpr size_t kFirstJoint = 1;

void add_skin(Document& document, const Character& character) {
  std::vector<std::array<float, 16>> inverse_binds;
  Json joints = Json::array();
  for (const CharacterJoint& joint : character.joints) {
    const auto& [x, y, z] = joint.position;
    inverse_binds.push_back({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -x, -y, -z, 1});
    std::array<float, 3> from_parent = joint.position;
    Json& nodes = document.json()["nodes"];
    const size_t node = nodes.size();
    if (joint.parent >= 0) {
      const auto parent = static_cast<size_t>(joint.parent);
      for (size_t k = 0; k < 3; ++k) from_parent[k] -= character.joints[parent].position[k];
      nodes[kFirstJoint + parent]["children"].push_back(node);
    }
    nodes.push_back({{"name", joint.name}, {"translation", from_parent}});
    joints.push_back(node);
  }
  const int64_t matrices = append_floats(document, inverse_binds);
  Json& json = document.json();
  json["skins"] = Json::array(
      {{{"joints", std::move(joints)}, {"inverseBindMatrices", matrices}, {"skeleton", kFirstJoint}}});
  json["nodes"][0]["skin"] = 0;
  json["scenes"][0]["nodes"].push_back(kFirstJoint);
}

void add_clip(Document& document, const Character& character) {
  Json samplers = Json::array(), channels = Json::array();
  const int64_t times = append_floats(document, character.times, 0, true);
  const auto add = [&](size_t node, const char* path, int64_t values) {
    channels.push_back({{"sampler", samplers.size()}, {"target", {{"node", node}, {"path", path}}}});
    samplers.push_back({{"input", times}, {"output", values}});
  };
  add(kFirstJoint, "translation", append_floats(document, character.translations));
  for (size_t j = 0; j < character.joints.size(); ++j)
    add(kFirstJoint + j, "rotation", append_floats(document, character.joints[j].rotations));
  add(0, "weights", append_floats(document, character.weights));
  document.json()["animations"] =
      Json::array({{{"name", "walk"}, {"channels", std::move(channels)}, {"samplers", std::move(samplers)}}});
}

}  // namespace

Document character_document(const Character& character) {
  Document document = document_from_mesh(character.mesh);
  add_targets(document, character);
  add_skin(document, character);
  add_clip(document, character);
  return document;
}

}  // namespace psplit
