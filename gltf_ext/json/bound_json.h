// The bounds of an accessor.
#pragma once

#include "gltf_ext/json/json_fwd.h"
#include "psplit/mesh.h"

namespace psplit {

// Bounds of values of that type as numbers of JSON: floats for floats.
Json bound_json(Span<const double> values, ComponentType type);

}  // namespace psplit
