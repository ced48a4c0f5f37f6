#include "gltf_ext/primitive/normal_lengths.h"

#include <cmath>
#include <cstring>
#include <set>

#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/primitive/accessors.h"
#include "gltf_ext/primitive/read_primitives.h"

namespace psplit {

namespace {

// Reads them in steps.
uint64_t odd_normals_in(const ValuesView& normals) {
  if (normals.component_type != ComponentType::kFloat32 || normals.component_count != 3) return 0;
  constexpr double kUnit = 0.01;  // more than the error of encoders with few bits
  uint64_t count = 0;
  for_each_step(normals, [&](size_t first, size_t end) {
    for (size_t i = first; i < end; ++i) {
      std::array<float, 3> v;
      std::memcpy(v.data(), normals.at(i), sizeof(v));
      const double square = double{v[0]} * v[0] + double{v[1]} * v[1] + double{v[2]} * v[2];
      count += !(std::fabs(std::sqrt(square) - 1) <= kUnit);
    }
    return true;
  });
  return count;
}

}  // namespace

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
    if (const Expected<ValuesView> view = accessor_view(document, index)) {
      count += odd_normals_in(*view);
    } else if (const Expected<AccessorData> data = read_accessor(document, index)) {
      count += odd_normals_in(*data);
    }
  }
  return count;
}

}  // namespace psplit
