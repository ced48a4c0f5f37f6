// Converts components of any type to any other type. The rules are libdraco's, as in src/cpu/convert.h. Here,
// one function converts all types at run time: the module is small, and few pages need this.
#pragma once

#include <cstdint>

#include "src/core/data_type.h"

namespace psplit::web {

// `in` and `out` need no alignment. Returns false if a component does not fit; `out` may then hold anything.
bool convert_components(const uint8_t* in, core::DataType from, bool normalized, uint32_t count,
                        core::DataType to, uint8_t* out);

}  // namespace psplit::web
