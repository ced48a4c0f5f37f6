// An independent test whether two meshes are the same, without any knowledge of encoders, patches or
// numberings.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "psplit/mesh.h"

namespace psplit {

// How much a value may differ from the expected one.
struct Tolerance {
  enum class Kind { kExact, kGrid, kOctahedral };
  Kind kind = Kind::kExact;
  int bits = 0;               // bits of the grid
  std::vector<float> origin;  // kGrid: one per component
  float range = 0;            // kGrid: value = origin + i * range / (2^bits - 1)
};

// Values must have the same bits.
Tolerance exact_tolerance();
// Values must round to the same grid point. A value halfway between two grid points may round to either.
Tolerance grid_tolerance(int bits, std::vector<float> origin, float range);
// Unit vectors must agree within the angle of an octahedral grid of `bits` bits. A vector of length zero may
// become any vector.
Tolerance octahedral_tolerance(int bits);

// Empty if the meshes are equal; otherwise a sentence that says where they first differ. Equal meshes have the
// same semantics and types, the same counts, the same triangles (multisets of the values at their corners, up
// to rotation), and the same used and unused points (multisets of values). `per_attribute` is in the order of
// the attributes of `expected`; if it is empty, all values must be exact.
std::string compare_meshes(const Mesh& expected, const Mesh& actual,
                           std::span<const Tolerance> per_attribute = {});

}  // namespace psplit
