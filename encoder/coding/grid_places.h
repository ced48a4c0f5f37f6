// Values that decoders cannot tell apart, because they are on one place of a grid.
#pragma once

#include <functional>

#include "psplit/base.h"
#include "psplit/encode.h"
#include "psplit/mesh.h"

namespace psplit {

// Replaces a value by what decoders make of the nearest place of its grid, bit for bit: three components of a
// direction, or as many as the grid has.
void round_to_grid(Span<float> value, const AttributeCoding& grid);

// Whether that changes no value of the attribute, or of its points whose flag in `stored` is set.
bool is_on_grid(const Attribute& attribute, const AttributeCoding& grid, Span<const uint8_t> stored);

// Returns for each attribute of the mesh, given by its index, bytes that are equal for values on one place of
// its grid. Empty for POSITION, whose values decide the topology, and for exact values. An empty function if
// that is all attributes. The mesh and its codings must outlive the function.
std::function<Array<std::byte>(size_t)> places_on_grids(const Mesh& mesh, Span<const AttributeCoding> codings);

}  // namespace psplit
