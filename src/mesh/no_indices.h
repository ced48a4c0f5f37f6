// The indices of a source without faces.
#pragma once

#include <cstddef>

#include "psplit/mesh.h"

namespace psplit {

// A view without bytes would say that each three points in their order are a face. This one has bytes and no
// indices.
inline ValuesView no_indices() {
  static constexpr std::byte kByte{};
  return {ComponentType::kUint32, 1, false, 0, {&kByte, 1}, 0};
}

}  // namespace psplit
