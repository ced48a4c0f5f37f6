#include "gltf_ext/primitive/normal_lengths.h"

#include <cmath>
#include <cstring>
#include <set>

#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/primitive/accessors.h"
#include "gltf_ext/primitive/read_primitives.h"

namespace psplit {

uint64_t count_odd_normals(const Document& document) {
  std::set<int64_t> accessors;
  for (const auto [mesh, primitive] : all_primitives(document)) {
    const Json* attributes = object_field(document.json["meshes"][mesh]["primitives"][primitive], "attributes");
    if (attributes == nullptr) continue;
    if (const auto index = integer_field(*attributes, "NORMAL")) accessors.insert(*index);
  }
  uint64_t count = 0;
  for (const int64_t index : accessors) {
    const Json* accessor = top_level_object(document.json, "accessors", index);
    if (accessor == nullptr || field(*accessor, "bufferView") == nullptr) continue;
    const Expected<AccessorData> data = read_accessor(document, index);
    if (!data || data->component_type != ComponentType::kFloat32 || data->component_count != 3) continue;
    constexpr double kUnit = 0.01;  // more than the error of encoders with few bits
    for (size_t i = 0; i < data->count; ++i) {
      std::array<float, 3> v;
      std::memcpy(v.data(), data->values.data() + i * sizeof(v), sizeof(v));
      const double square = double{v[0]} * v[0] + double{v[1]} * v[1] + double{v[2]} * v[2];
      count += !(std::fabs(std::sqrt(square) - 1) <= kUnit);
    }
  }
  return count;
}

}  // namespace psplit
