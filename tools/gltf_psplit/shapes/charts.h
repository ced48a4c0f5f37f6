// Texture coordinates in several charts, and the seams between them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tools/gltf_psplit/shapes/fields.h"
#include "tools/gltf_psplit/shapes/isosurface.h"

namespace psplit {

// Which vertex of the surface each point shows, and where it lies in the texture. Points 0 ... vertices - 1 are
// the vertices themselves; those on seams come again at the end, once for each further chart.
struct ChartedPoints {
  std::vector<uint32_t> vertex;
  std::vector<std::array<float, 2>> texcoords;
};

// Closed surfaces get the six sides of a box, by the side that each face's centre looks to from the middle;
// open ones get 3 x 2 tiles. Rewrites the surface's faces from vertices to points.
ChartedPoints unfold(Surface& surface, const Field& field);

}  // namespace psplit
