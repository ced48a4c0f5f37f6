// A mesh in parts, of which one is in memory at a time.
#pragma once

#include <cstdint>
#include <vector>

#include "psplit/base.h"
#include "psplit/mesh.h"

namespace psplit {

// Some faces of a mesh with the points that they use.
struct MeshPart {
  // Faces that repeat an index are stored, and so are points that no face of the part uses, unless other parts
  // use them as well.
  Mesh mesh;
  // The points of `mesh` that other parts use as well, in ascending order.
  std::vector<uint32_t> shared_points;
  // The number of each of them among all such points of the whole mesh.
  std::vector<uint32_t> shared_numbers;
};

// All parts have the same attributes in the same order. A shared point has the same values in all of its parts.
class MeshParts {
 public:
  virtual ~MeshParts() = default;
  virtual uint32_t part_count() const = 0;
  // The number of points that several parts use: shared numbers are below it.
  virtual uint32_t shared_count() const = 0;
  // `part` is below part_count(). A part may be read again. Errors are the implementation's.
  virtual Expected<MeshPart> read(uint32_t part) = 0;
};

}  // namespace psplit
