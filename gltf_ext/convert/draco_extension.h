// The extension object of a primitive whose attributes are in Draco streams.
#pragma once

#include <span>

#include "gltf_ext/primitive/primitive_edit.h"

namespace psplit {

// Makes the container or stream in a buffer view the extension `name` of the group's primitives. Replaces any
// Draco extension that they had.
void set_draco_extension(Document& document, const PrimitiveGroup& group, const char* name, int64_t buffer_view,
                         std::span<const AttributeRequest> requests);

}  // namespace psplit
