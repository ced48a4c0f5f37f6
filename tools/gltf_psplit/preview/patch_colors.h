// A colour for every patch: even in lightness, far from those of its neighbours.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tools/gltf_psplit/shapes/vec3.h"

namespace psplit {

using Color = Vec3;  // red, green and blue of sRGB's primaries, linear in light, 0 to 1

// Patch p has faces [face_base[p], face_base[p + 1]); patches that use the same point are neighbours. `first`
// is the place of patch 0 in the endless series of colours: the number of those that others took.
// Deterministic.
std::vector<Color> patch_colors(std::span<const std::array<uint32_t, 3>> faces, uint32_t point_count,
                                std::span<const uint32_t> face_base, size_t first = 0);

}  // namespace psplit
