// How the values of one attribute are stored.
#pragma once

#include <vector>

namespace psplit {

// bits == 0 keeps the values exactly as they are.
struct AttributeCoding {
  int bits = 0;             // 1 to 30; only for kFloat32 attributes
  bool octahedral = false;  // NORMAL: unit vectors on an octahedral grid of `bits` (2 to 30)
  // The grid of every other quantized attribute: value = origin + i * range / (2^bits - 1), one origin per
  // component. The same for all meshes that must fit together. Made by fit_grid and merge_grids, which see to
  // it that libdraco reproduces it to the bit.
  std::vector<float> origin;
  float range = 0;
};

}  // namespace psplit
