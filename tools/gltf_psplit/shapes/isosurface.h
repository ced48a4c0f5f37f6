// Marching tetrahedra on a jittered grid: the zero set of a field as a manifold triangle mesh.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "src/mesh/mesh.h"
#include "src/parallel.h"
#include "tools/gltf_psplit/shapes/fields.h"

namespace psplit {

struct Surface {
  double cell = 0;  // edge length of the grid cells
  std::vector<std::array<float, 3>> positions;
  Array<std::array<uint32_t, 3>> faces;  // counter-clockwise seen from outside
};

// `cell` is the edge length of a grid cell. Every cube is cut into the same six tetrahedra, so adjacent cubes
// agree on their diagonals and the surface has no cracks: an edge has two faces, or one at the sides of the box
// if the field is not closed. Works slab by slab; the result does not depend on the number of threads.
Surface extract_surface(const Field& field, double cell, uint64_t seed, const ThreadPool& pool);

}  // namespace psplit
