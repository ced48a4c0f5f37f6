// A mesh and which of its points share a value.
#pragma once

#include <cstdint>
#include <vector>

#include "src/mesh/mesh.h"

namespace psplit {

// Points with the same entry in value_of_point share that attribute's value. Points that share a position make
// a vertex; different values at a vertex make a seam.
struct WeldedMesh {
  const Mesh* mesh = nullptr;
  // For each attribute of the mesh and each point, the lowest point that has the same value.
  std::vector<std::vector<uint32_t>> value_of_point;
};

}  // namespace psplit
