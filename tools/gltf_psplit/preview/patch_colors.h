// A colour for every patch: all equally light, each far from the colours of its neighbours.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tools/gltf_psplit/shapes/vec3.h"

namespace psplit {

using Color = Vec3;  // linear red, green and blue with the primaries of sRGB, from 0 to 1

// Patch p has the faces [face_base[p], face_base[p + 1]). Patches that share a point are neighbours. `first` is
// the index of patch 0 in the endless series of colours, so that several meshes can continue one series.
// Deterministic.
std::vector<Color> patch_colors(std::span<const std::array<uint32_t, 3>> faces, uint32_t point_count,
                                std::span<const uint32_t> face_base, size_t first = 0);

}  // namespace psplit
