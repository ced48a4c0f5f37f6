// Meshes whose bits are the same on every machine. They use only sums, products and square roots, which IEEE
// 754 rounds exactly, and no other function of libm. Tests that pin the encoder's bytes use them.
#pragma once

#include <cstdint>
#include <span>

#include "psplit/mesh.h"

namespace psplit {

// A curved sheet of columns x rows quads, with an attribute for each way of coding: grids, octahedral normals
// and integers.
Mesh make_sheet(uint32_t columns, uint32_t rows);

// A sheet of 40 x 30 quads with degenerate faces, points that no face uses and duplicate points.
Mesh make_sheet_with_residue();

// The 64-bit FNV-1a hash.
uint64_t fnv1a(std::span<const uint8_t> bytes);

}  // namespace psplit
