// Sweeping: accessors, buffer views and bytes that nothing refers to any more are dropped.
#pragma once

#include <vector>

#include "gltf_ext/document/document.h"

namespace psplit {

// Drops the accessors `freed_accessors` that nothing refers to, and all buffer views that nothing refers to,
// with their bytes. Renumbers the references to the rest, also in known extensions. Accessors and views to
// which an unknown extension might refer are kept.
void drop_unused(Document& document, const std::vector<int64_t>& freed_accessors);

}  // namespace psplit
