// Converts between Unity's coordinates, which are left-handed, and glTF's.
#pragma once

#include <cstdint>

namespace psplit::unity {

// Of two components the second is counted from the other side; of three the first changes its sign, of four the
// second and the third. Values keep their type. A second call undoes the first.
template <typename T>
void flip_value(T* value, uint32_t components) {
  const auto negate = [](T& component) { component = static_cast<T>(-component); };
  if (components == 2) value[1] = static_cast<T>(1 - value[1]);
  if (components == 3) negate(value[0]);
  if (components == 4) negate(value[1]), negate(value[2]);
}

}  // namespace psplit::unity
