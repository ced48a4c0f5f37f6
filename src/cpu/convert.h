// Converts values from the type that a stream stores to another type. The two may differ in real assets. The
// rules are libdraco's.
#pragma once

#include <cstddef>

#include "psplit/draco_types.h"

namespace psplit {

// Converts `count` components. `normalized` is the stored attribute's. Returns false if a component does not
// fit type `to`; those before it are written.
bool convert_components(const uint8_t* in, DataType from, bool normalized, size_t count, DataType to,
                        uint8_t* out);

}  // namespace psplit
