// With how many bits the attributes of a mesh are stored.
#pragma once

#include <set>
#include <string>

#include "src/export.h"

namespace psplit {

// The attributes whose bits the user states.
struct GivenBits {
  bool position = false, normal = false, texcoord = false, color = false, generic = false;
};

// Bits of a component on its quantization grid; 0 keeps the values exactly as they are.
struct CodingOptions {
  int position_bits = 14, normal_bits = 10, texcoord_bits = 12, color_bits = 8, generic_bits = 12;
  bool lossless = false;  // every attribute exactly as it is
  // Grids of given bits stay, even if they lose what the mesh tells apart.
  GivenBits given{};
  std::set<std::string> exact{};  // names of attributes that are kept exactly

  // For callers who do not know what the user states: bits that differ from the default count as given.
  PSPLIT_EXPORT void give_changed_bits();
};

}  // namespace psplit
