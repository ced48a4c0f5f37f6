// Sweeping: accessors, buffer views and bytes that nothing refers to any more are dropped.
#pragma once

#include <vector>

#include "gltf_ext/document/document.h"

namespace psplit {

// Drops accessors and buffer views in `freed_accessors` and those buffer views that nothing refers to any
// more, renumbers what refers to the rest (known extensions included), and drops the bytes. Keeps a view when
// an unknown extension might refer to it.
void drop_unused(Document& document, const std::vector<int64_t>& freed_accessors);

}  // namespace psplit
