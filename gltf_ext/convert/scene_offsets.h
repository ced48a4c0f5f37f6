// How nodes move meshes against each other.
#pragma once

#include <array>
#include <cstddef>
#include <set>

#include "gltf_ext/json/json_fwd.h"

namespace psplit {

struct SceneOffsets {
  // Nodes only move some of the meshes. Otherwise they also turn or scale them, or there are too many of them.
  bool are_translations = true;
  // The translations, in the coordinates of the nodes' common ancestor, relative to one of the meshes. Zeros
  // are left out.
  std::set<std::array<double, 3>> offsets{};

  bool are_zero() const { return are_translations && offsets.empty(); }
};

// The offsets of these meshes, in all scenes. Skinned meshes and animations do not count.
SceneOffsets scene_offsets(const Json& json, const std::set<size_t>& meshes);

}  // namespace psplit
