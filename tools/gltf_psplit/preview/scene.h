// The places of the meshes of an asset.
#pragma once

#include <string_view>
#include <vector>

#include "gltf_ext/document/document.h"
#include "tools/gltf_psplit/shapes/vec3.h"

namespace psplit {

// An affine map, given by the images of the three axes and of the origin.
struct Transform {
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, origin;

  Vec3 direction(Vec3 d) const { return x * d.x + y * d.y + z * d.z; }
  Vec3 point(Vec3 p) const { return direction(p) + origin; }
  // Maps a surface normal so that it stays perpendicular to the surface. Its length changes, and a mirroring
  // map reverses it.
  Vec3 normal(Vec3 n) const { return cross(y, z) * n.x + cross(z, x) * n.y + cross(x, y) * n.z; }
};
// Whether it mirrors, that is, swaps right-handed and left-handed.
bool mirrors(const Transform& transform);
// Where a POSITION goes, or a NORMAL or a TANGENT, which gets the length 1. `mirrored`: mirrors(transform).
Vec3 moved(const Transform& transform, bool mirrored, std::string_view semantic, Vec3 value);
// Applies `inner` first, then `outer`.
Transform operator*(const Transform& outer, const Transform& inner);

struct MeshInstance {
  size_t mesh = 0;
  Transform to_world;
};

// The meshes of the default scene, or of the first scene if none is the default, in the order of its nodes. If
// there is no scene, every mesh once. Skins, morph targets, animations and EXT_mesh_gpu_instancing are ignored.
// Cycles are kInvalidInput.
Expected<std::vector<MeshInstance>> scene_instances(const Document& document);

}  // namespace psplit
