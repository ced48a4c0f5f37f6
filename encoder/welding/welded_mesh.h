// A mesh and which of its points share a value.
#pragma once

#include <cstdint>
#include <vector>

#include "src/mesh/mesh.h"

namespace psplit {

// Points of a mesh and the values they use. Two points share a value of an attribute where value_of_point says
// so: shared positions make a vertex, differing values around a vertex make a seam.
struct WeldedMesh {
  const Mesh* mesh = nullptr;
  // Per attribute of the mesh, for each point the lowest point that holds the same value.
  std::vector<std::vector<uint32_t>> value_of_point;
};

}  // namespace psplit
