// Quantization grids that libdraco keeps to the bit.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "encoder/encode_mesh.h"

namespace psplit {

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
void round_weights(Mesh& mesh, std::span<const AttributeCoding> codings);

}  // namespace psplit
