#include "gltf_ext/json/bound_json.h"

#include "gltf_ext/json/json.h"

namespace psplit {

Json bound_json(Span<const double> values, ComponentType type) {
  Json bound = Json::array();
  for (const double value : values)
    if (type == ComponentType::kFloat32)
      bound.push_back(static_cast<float>(value));
    else
      bound.push_back(static_cast<int64_t>(value));
  return bound;
}

}  // namespace psplit
