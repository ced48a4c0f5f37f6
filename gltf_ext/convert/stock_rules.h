// The rules of KHR_draco_mesh_compression: accessors say what the stream has.
#pragma once

#include <vector>

#include "gltf_ext/convert/validate.h"

namespace psplit {

// Checks a primitive in stock Draco. `mesh` is its decoded mesh. Accessors whose bounds are off by no more than
// a step of the stream's grid are right: many encoders state the bounds from before they quantized.
std::vector<Finding> check_stock_primitive(const Document& document, PrimitiveId id, const MeshView& mesh);

// Only the rule "accessor-count".
std::vector<Finding> check_stock_counts(const Document& document, PrimitiveId id, const MeshView& mesh);

}  // namespace psplit
