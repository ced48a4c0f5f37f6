#include "gltf_ext/primitive/normal_lengths.h"

#include <cmath>
#include <cstring>
#include <set>

#include "gltf_ext/primitive/accessors.h"

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
  const AssetRecords& records = document.records();
  std::set<int64_t> accessors;
  for (const PrimitiveId id : all_primitives(document))
    if (const int64_t index = records.primitive(id).accessor_of("NORMAL"); index >= 0) accessors.insert(index);
  uint64_t count = 0;
  for (const int64_t index : accessors) {
    if (!records.accessor(index).has_view()) continue;
    if (const Expected<ValuesView> view = accessor_view(document, index)) {
      count += odd_normals_in(*view);
    } else if (const Expected<AccessorData> data = read_accessor(document, index)) {
      count += odd_normals_in(*data);
    }
  }
  return count;
}

}  // namespace psplit
