// Whether two meshes are the same in every bit of their faces and values, in their order.
// compare_meshes.h tells whether they are the same in any order.
#pragma once

#include <algorithm>

#include "psplit/mesh.h"

namespace psplit {

inline bool same_bits(const Mesh& a, const Mesh& b) {
  return a.point_count == b.point_count && a.faces == b.faces &&
         std::equal(a.attributes.begin(), a.attributes.end(), b.attributes.begin(), b.attributes.end(),
                    [](const Attribute& x, const Attribute& y) { return x.values == y.values; });
}

}  // namespace psplit
