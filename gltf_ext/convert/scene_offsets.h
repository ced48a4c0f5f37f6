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
  // By how much, in the coordinates that the meshes have before the nodes above all of them count; relative to
  // one of the meshes. Only those that are not zero.
  std::set<std::array<double, 3>> offsets{};

  bool are_zero() const { return are_translations && offsets.empty(); }
};

// Of these meshes, in all scenes. Skinned meshes, and animations, do not count.
SceneOffsets scene_offsets(const Json& json, const std::set<size_t>& meshes);

}  // namespace psplit
