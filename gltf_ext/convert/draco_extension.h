// The extension object of a primitive whose attributes are in Draco streams.
#pragma once

#include <vector>

#include "gltf_ext/primitive/primitive_edit.h"

namespace psplit {

// How a decoder gets the attributes of `mesh` back; unique_ids[i] is Draco's id of attribute i.
std::vector<AttributeRequest> requests_of(const Mesh& mesh, const std::vector<uint32_t>& unique_ids);

// Makes the container or stream in a buffer view the extension `name` of the group's primitives. Replaces any
// Draco extension that they had.
void set_draco_extension(Document& document, const PrimitiveGroup& group, const char* name, int64_t buffer_view,
                         const Mesh& mesh, const std::vector<uint32_t>& unique_ids);

}  // namespace psplit
