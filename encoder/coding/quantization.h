// Quantization grids that libdraco keeps to the bit.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "encoder/coding/attribute_coding.h"
#include "src/export.h"
#include "src/mesh/mesh.h"
#include "src/status.h"

namespace psplit {

// The grid that holds all values of the attribute. Fails on NaN and infinity.
PSPLIT_EXPORT Expected<AttributeCoding> fit_grid(const Attribute& attribute, int bits);
// The smallest grid of the same bits that holds both.
PSPLIT_EXPORT AttributeCoding merge_grids(const AttributeCoding& a, const AttributeCoding& b);

// The values whose bounding box is the grid's: libdraco takes origin and range from the extremes of an
// attribute's values, computing range as the largest (maximum - minimum). Nothing where no float gives exactly
// the range.
//
// (libdraco's explicit quantization will not do: it passes numbers as text of six decimals.)
struct GridExtremes {
  std::vector<float> low, high;
};
std::optional<GridExtremes> grid_extremes(const AttributeCoding& coding);

// Puts values that are beyond glTF's limits by no more than rounding noise back on them: then fit_grid's grid
// ends there too, and no decoded value is outside.
void trim_noise(Attribute& attribute);

// Rounds quantized weights to their grid such that the weights of a point, all WEIGHTS_n together, keep their
// sum, which glTF wants to be one; a sum that is nearly one becomes one.
PSPLIT_EXPORT void round_weights(Mesh& mesh, std::span<const AttributeCoding> codings);

// How far what libdraco decodes may be from what it was given: a component on a grid, and the chord between
// unit vectors on an octahedron.
double grid_bound(int bits, float origin, float range);
double octahedral_bound(int bits);

}  // namespace psplit
