// What the values of a mesh show: data that can be decoded, and that no viewer shows as its author meant.
#pragma once

#include <vector>

#include "gltf_ext/convert/validate.h"

namespace psplit {

// Warnings about the values of a primitive that has triangles, from its decoded mesh: "finite", "unit-normals",
// "weights-sum" and "joints-range". Values may differ from what glTF asks by what quantization takes.
std::vector<Finding> check_values(const Document& document, PrimitiveId id, const MeshView& mesh);

// The warnings "target-count" of lines and points, which are not decoded.
std::vector<Finding> check_target_counts(const Document& document, PrimitiveId id);

}  // namespace psplit
