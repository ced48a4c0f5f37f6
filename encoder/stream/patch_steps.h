// The steps on the grids of a patch, where they are too many for libdraco's encoder.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "encoder/stream/patch_mesh.h"
#include "encoder/welding/weld.h"
#include "psplit/encode.h"

namespace psplit {

// Whether texture coordinates that are predicted from positions (predicts_texture) have products that may
// exceed 64 bits. libdraco's encoder then fails, or writes a stream that newer versions of its decoder refuse.
// That needs grids of many bits, and edges about as long as the grid of positions. `texcoords` is the index of
// an attribute of the mesh that has two components.
bool texture_prediction_may_overflow(const WeldedMesh& welded, const PatchMesh& patch,
                                     std::span<const AttributeCoding> codings, size_t texcoords);

}  // namespace psplit
