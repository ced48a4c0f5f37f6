// Surfaces with approximately a given number of faces, and their normals.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "psplit/base.h"
#include "psplit/parallel.h"
#include "tools/gltf_psplit/shapes/fields.h"
#include "tools/gltf_psplit/shapes/isosurface.h"

namespace psplit {

// The edge length of a grid cell for which the surface has about `faces` faces. `count_faces` extracts the
// surface for a cell; the last cell may not be the result. Errors: of count_faces; kRuntime if the surface has
// no faces.
Expected<double> find_cell(uint64_t faces, const std::function<Expected<uint64_t>(double cell)>& count_faces);

struct SizedSurface {
  double cell = 0;
  Surface surface;
};
Expected<SizedSurface> extract_about(const Field& field, uint64_t faces, uint64_t seed, const ThreadPool& pool);

// The direction in which the field grows, from central differences over `step` on each side.
std::array<float, 3> normal_at(const Field& field, const std::array<float, 3>& position, double step);

}  // namespace psplit
