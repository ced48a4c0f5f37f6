// Where the meshes of an asset stand.
#pragma once

#include <vector>

#include "gltf_ext/document/document.h"
#include "tools/gltf_psplit/shapes/vec3.h"

namespace psplit {

// An affine map: where the three axes and the origin go.
struct Transform {
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, origin;

  Vec3 direction(Vec3 d) const { return x * d.x + y * d.y + z * d.z; }
  Vec3 point(Vec3 p) const { return direction(p) + origin; }
  // Of a normal of a surface, which stays perpendicular to it; its length changes, and it flips with mirrors.
  Vec3 normal(Vec3 n) const { return cross(y, z) * n.x + cross(z, x) * n.y + cross(x, y) * n.z; }
};
// First `inner`, then `outer`.
Transform operator*(const Transform& outer, const Transform& inner);

struct MeshInstance {
  size_t mesh = 0;
  Transform to_world;
};

// The meshes of the default scene, or else of the first; every mesh once where there is no scene. What skins,
// morph targets, animations and EXT_mesh_gpu_instancing change is left as it was. Cycles are kInvalidInput.
Expected<std::vector<MeshInstance>> scene_instances(const Document& document);

}  // namespace psplit
