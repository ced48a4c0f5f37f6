// Texture coordinates in several charts, with seams between them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tools/gltf_psplit/shapes/fields.h"
#include "tools/gltf_psplit/shapes/isosurface.h"

namespace psplit {

// The vertex of the surface and the texture coordinates of each point. Points 0 ... vertices - 1 are the
// vertices themselves. A vertex on a seam has another point at the end for each further chart.
struct ChartedPoints {
  std::vector<uint32_t> vertex;
  std::vector<std::array<float, 2>> texcoords;
};

// A closed surface gets six charts, one for each side of a box; a face belongs to the side that its centre is
// nearest to in direction. An open surface gets 3 x 2 tiles. Rewrites the surface's faces from vertices to
// points.
ChartedPoints unfold(Surface& surface, const Field& field);

}  // namespace psplit
