// The codings of a test's mesh, with how far decoded values may be off.
#pragma once

#include <vector>

#include "psplit/encode.h"
#include "psplit/mesh.h"
#include "tests/support/compare_meshes.h"

namespace psplit {

struct Coded {
  std::vector<AttributeCoding> codings;
  std::vector<Tolerance> tolerances;
};

// The defaults of the command line; what a grid cannot hold is kept exactly.
Coded default_codings(const Mesh& mesh, bool lossless);

}  // namespace psplit
