// Values that decoders cannot tell apart, because they are on one place of a grid.
#pragma once

#include <array>
#include <functional>
#include <span>

#include "encoder/coding/attribute_coding.h"
#include "src/export.h"
#include "src/mesh/mesh.h"

namespace psplit {

// The value that a decoder makes of the nearest place of an octahedral grid of `bits`.
PSPLIT_EXPORT std::array<float, 3> round_direction(const std::array<float, 3>& vector, int bits);

// Returns for each attribute of the mesh, given by its index, bytes that are equal for values on one place of
// its grid. Empty for POSITION, whose values decide the topology, and for exact values. An empty function if
// that is all attributes. The mesh and its codings must outlive the function.
PSPLIT_EXPORT std::function<Array<std::byte>(size_t)> places_on_grids(const Mesh& mesh,
                                                                      std::span<const AttributeCoding> codings);

}  // namespace psplit
