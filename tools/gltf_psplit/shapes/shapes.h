// Built-in sample meshes: irregular isosurfaces, generated from a seed, that a mesh codec compresses like
// scans.
#pragma once

#include <cstdint>
#include <vector>

#include "src/mesh/mesh.h"
#include "src/parallel.h"
#include "src/status.h"

namespace psplit {

enum class Shape {
  kTerrain,  // an open sheet with hills and overhangs
  kBlob,     // a closed, bumpy ball
  kGyroid,   // a closed solid of high genus: a gyroid cut by a ball
  kScene,    // six objects of different shapes and sizes, terrain first
};

struct ShapeOptions {
  Shape shape = Shape::kTerrain;
  uint64_t faces = 0;  // of all meshes together; from some thousand faces per mesh, the result is within 2 %
  uint64_t seed = 0;
  bool normals = false;    // NORMAL, from the gradient of the field
  bool texcoords = false;  // TEXCOORD_0 in several charts, so that points on chart borders are duplicated
};

// Makes one mesh, or six for kScene. The bytes depend only on the options, not on threads, compiler or machine.
// Meshes are manifold and consistently oriented; no two points are equal, and no face is degenerate. Memory is
// proportional to the output, plus two grid layers per thread. Errors: kUsage (faces out of range).
Expected<std::vector<Mesh>> generate_shape(const ShapeOptions& options, const ThreadPool& pool);

}  // namespace psplit
