// Proves that a container holds the mesh it was made from.
#pragma once

#include <span>

#include "encoder/coding/attribute_coding.h"
#include "src/mesh/mesh.h"
#include "src/status.h"

namespace psplit {

// `decoded` is what a decoder made of the container, `source_point` the claim of which input point each of its
// points is. The claim must be a bijection onto the points of `mesh`; under it the faces must be the same with
// the same orientation, exact attributes the same bits, and quantized ones within half a step of their grid.
Status verify_decoded(const Mesh& mesh, std::span<const AttributeCoding> codings, const Mesh& decoded,
                      std::span<const uint32_t> source_point);

}  // namespace psplit
