// Marching tetrahedra on a jittered grid: the zero set of a field as a manifold triangle mesh.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "psplit/base.h"
#include "psplit/mesh.h"
#include "psplit/parallel.h"
#include "tools/gltf_psplit/shapes/fields.h"

namespace psplit {

struct Surface {
  std::vector<std::array<float, 3>> positions;
  Array<std::array<uint32_t, 3>> faces;  // counter-clockwise seen from outside
};

// Hands the surface over slab by slab, from the lowest z to the highest. Faces have their final point numbers.
// They may refer to the first points of the next slab. `take` is called by the calling thread; its error ends
// the work and is returned.
//
// `cell` is the edge length of a grid cell. Every cube is cut into the same six tetrahedra, so adjacent cubes
// agree on their diagonals and the surface has no cracks: an edge has two faces, or one at the sides of the box
// if the field is not closed. The result does not depend on the number of threads. Memory: two slabs of the
// surface for each thread. It does not grow with the number of the grid's nodes.
Status stream_surface(const Field& field, double cell, uint64_t seed, const ThreadPool& pool,
                      const std::function<Status(Surface&&)>& take);

}  // namespace psplit
