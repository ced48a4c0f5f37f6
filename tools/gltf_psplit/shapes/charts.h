// Texture coordinates in several charts, with seams between them.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "tools/gltf_psplit/shapes/isosurface.h"
#include "tools/gltf_psplit/shapes/vec3.h"

namespace psplit {

// Which chart a face belongs to, and where each chart is in the texture.
class Atlas {
 public:
  virtual ~Atlas() = default;
  virtual uint8_t chart(Vec3 face_centre) const = 0;  // below kNoChart
  virtual std::array<float, 2> texcoord(uint8_t chart, const std::array<float, 3>& position) const = 0;
};
inline constexpr uint8_t kNoChart = 255;

// The vertex of the surface, the chart and the texture coordinates of each point. Points 0 ... vertices - 1 are
// the vertices themselves. A vertex on a seam has another point at the end for each further chart.
struct ChartedPoints {
  std::vector<uint32_t> vertex;
  std::vector<uint8_t> chart;
  std::vector<std::array<float, 2>> texcoords;
};

Vec3 centre_of(const Surface& surface, const std::array<uint32_t, 3>& face);

// Rewrites the surface's faces from vertices to points.
ChartedPoints unfold(Surface& surface, const Atlas& atlas);

}  // namespace psplit
