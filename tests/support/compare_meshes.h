// The independent judge of "the same mesh": it knows nothing of encoders, patches or numberings.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "src/mesh/mesh.h"

namespace psplit {

// How far a value may be from the one that was expected.
struct Tolerance {
  enum class Kind { kExact, kGrid, kOctahedral };
  Kind kind = Kind::kExact;
  int bits = 0;               // of the grid
  std::vector<float> origin;  // kGrid: one per component
  float range = 0;            // kGrid: value = origin + i * range / (2^bits - 1)
};

// Bit for bit.
Tolerance exact_tolerance();
// On the same point of the grid; a value halfway between two points may go to either.
Tolerance grid_tolerance(int bits, std::vector<float> origin, float range);
// Unit vectors within the angle that an octahedral grid of so many bits leaves. A vector of no length may
// become any.
Tolerance octahedral_tolerance(int bits);

// Empty where the meshes are equal: the same semantics and types, the same counts, the same triangles
// (multisets of the values at their corners, up to rotation), the same used and the same unused points
// (multisets of values). Else a sentence that says where they first differ. `per_attribute` follows the
// attributes of `expected`; an empty one means exact throughout.
std::string compare_meshes(const Mesh& expected, const Mesh& actual,
                           std::span<const Tolerance> per_attribute = {});

}  // namespace psplit
