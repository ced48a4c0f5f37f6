// Proves that a container holds the mesh it was made from.
#pragma once

#include "encoder/encode_mesh.h"

namespace psplit {

// `decoded` is what a decoder made of the container, `source_point` the claim of which input point each of its
// points is. The claim must be a bijection onto the points of `mesh`; under it the faces must be the same with
// the same orientation, exact attributes the same bits, and quantized ones within half a step of their grid.
Status verify_decoded(const Mesh& mesh, std::span<const AttributeCoding> codings, const Mesh& decoded,
                      std::span<const uint32_t> source_point);

// How far what libdraco decodes may be from what it was given: a component on a grid, and the chord between
// unit vectors on an octahedron.
double grid_bound(int bits, float origin, float range);
double octahedral_bound(int bits);

}  // namespace psplit
