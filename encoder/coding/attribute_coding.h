// How the values of one attribute are stored.
#pragma once

#include <string>
#include <vector>

namespace psplit {

inline constexpr int kMostGridBits = 30;  // of a component on a quantization grid: libdraco's limit

// bits == 0 keeps the values exactly as they are.
struct AttributeCoding {
  int bits = 0;             // 1 to kMostGridBits; only for kFloat32 attributes
  bool octahedral = false;  // NORMAL: unit vectors on an octahedral grid of `bits` (2 or more)
  // The grid of every other quantized attribute: value = origin + i * range / (2^bits - 1). Each component has
  // an origin of its own. Meshes that must fit together need the same grid. The encoder fits grids that
  // libdraco reproduces to the bit.
  std::vector<float> origin;
  float range = 0;
  bool exact = false;  // every value is on the grid, and comes back as it is
};

// A sentence about an attribute, which it names.
struct PrecisionNote {
  std::string text;
  bool is_warning = false;  // something is lost: the caller gave the bits, so that nothing was done
};

}  // namespace psplit
