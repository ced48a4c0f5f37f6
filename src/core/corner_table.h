// The corner table: who lies across each edge, and which vertex is at each corner.
//
// Corner k of face f is number 4 * f + k, k = 0, 1, 2, counter-clockwise; numbers with k = 3 stay unused, which
// saves the division by three in face, next and previous. Tables are of 16-bit numbers where a patch has at
// most 16,383 faces, else of 32-bit ones.
//
//            v                 opposite(c): the corner that looks at c over the edge between them
//           /c\                next(c), previous(c): around the face, counter-clockwise
//          /   \               swing_right(c), swing_left(c): around the vertex, clockwise and back
//   next  *-----*  previous
//          \   /
//           \o/
#pragma once

#include "src/core/view.h"

namespace psplit::core {

template <typename Index>
inline constexpr Index kNone = static_cast<Index>(~Index{0});

// The most faces whose corners Index can number.
template <typename Index>
inline constexpr uint64_t kMaxFaces = (uint64_t{kNone<Index>}) / 4;

template <typename Index>
PSPLIT_HD constexpr Index next(Index corner) {
  const uint32_t c = corner, is_last = c >> 1 & 1;
  return static_cast<Index>(c + 1 - 3 * is_last);
}
template <typename Index>
PSPLIT_HD constexpr Index previous(Index corner) {
  const uint32_t c = corner, is_not_first = ((c & 3) + 1) >> 1;
  return static_cast<Index>(c + 2 - 3 * is_not_first);
}

template <typename Index>
struct CornerTable {
  View<Index> opposite;  // kNone on a boundary, and on a seam where the table is an attribute's
  View<Index> vertex;

  PSPLIT_HD Index swing_left(Index corner) const {
    const Index across = opposite[next(corner)];
    return across == kNone<Index> ? across : next(across);
  }
  PSPLIT_HD Index swing_right(Index corner) const {
    const Index across = opposite[previous(corner)];
    return across == kNone<Index> ? across : previous(across);
  }
};

}  // namespace psplit::core
