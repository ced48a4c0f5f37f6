// A built-in character as games have them: one mesh with seams in its normals and texture coordinates, a skin,
// morph targets of its face and body, and a clip of an animation.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "psplit/base.h"
#include "psplit/mesh.h"
#include "psplit/parallel.h"

namespace psplit {

struct CharacterJoint {
  std::string name;
  int parent = -1;                              // an earlier joint; -1 for the root
  std::array<float, 3> position{};              // of the mesh as it is stored
  std::vector<std::array<float, 4>> rotations;  // x, y, z, w, one for each of the clip's times
};

struct CharacterTarget {
  std::string name;
  std::vector<std::array<float, 3>> positions, normals;  // differences, one for each point
};

struct Character {
  Mesh mesh;  // POSITION, NORMAL, TEXCOORD_0, JOINTS_0, WEIGHTS_0
  std::vector<CharacterJoint> joints;
  std::vector<CharacterTarget> targets;
  std::vector<float> times;                        // of the clip, in seconds
  std::vector<std::array<float, 3>> translations;  // of the root, one for each time
  std::vector<float> weights;                      // of all targets at the first time, then at the next, ...
};

// `faces` is approximate, as in generate_shape, and the result depends as little on threads, compiler and
// machine. The mesh is closed and manifold. Errors: kUsage (faces out of range).
Expected<Character> generate_character(uint64_t faces, uint64_t seed, const ThreadPool& pool);

}  // namespace psplit
