// Skin weights on a grid that still sum to one.
#pragma once

#include <span>

#include "encoder/encode_mesh.h"

namespace psplit {

// Moves the values of all WEIGHTS_n that are coded on unit grids of the same bits to steps of that grid, each
// to the one below or above it, so that those of a point that sum to one do so still, as glTF asks. Rounding
// each to its nearest step, as quantization does, would not.
void round_weights(Mesh& mesh, std::span<const AttributeCoding> codings);

}  // namespace psplit
