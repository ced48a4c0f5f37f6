// The grids of morph targets.
#pragma once

#include "psplit/base.h"
#include "psplit/encode.h"

namespace psplit {

// Chooses the grids of morph targets of floats, and rounds their deltas to them. MeshToEncode::unrounded keeps
// the deltas as they were. The step is that of the attribute that a target changes, so that base + weight *
// delta is off by no more than the base; CodingOptions::morph_bits makes it another. Meshes of a group have one
// step, so that they stay joined. A delta of 0 stays 0 exactly, and a target has the bits that its own deltas
// need. Deltas stay exact if the attribute that they change does, if one is not finite, or if they need too
// many bits.
//
// Call it when all other codings of the meshes are final.
void choose_target_codings(Span<MeshToEncode* const> meshes, const CodingOptions& options);

}  // namespace psplit
