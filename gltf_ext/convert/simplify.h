// Meshes of few faces that look like meshes of many.
#pragma once

#include <span>
#include <vector>

#include "psplit/base.h"
#include "psplit/mesh.h"

namespace psplit {

using Faces = Array<std::array<uint32_t, 3>>;

// Simplifies meshes that touch, such as the primitives of a glTF mesh, to about `target` faces together.
// Returns the faces of each, whose points are points of that mesh: none where a mesh is too small to be seen.
// At least one face is left. Surfaces that share positions stay joined as far as meshoptimizer's simplifier
// allows it: it keeps the seams of normals and texture coordinates, unless too many faces are left with them.
// Each mesh must have positions, and there must be a face. Positions that are not finite count as 0. Errors:
// kUsage if this psplit was built without meshoptimizer.
Expected<std::vector<Faces>> simplify(std::span<const Mesh> meshes, uint64_t target);

}  // namespace psplit
