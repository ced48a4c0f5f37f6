// Quantization grids that libdraco keeps to the bit.
#pragma once

#include <optional>
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

}  // namespace psplit
