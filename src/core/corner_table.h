// The corner table: the vertex at each corner, and the corner across each edge.
//
// Corner k of face f has number 4 * f + k, with k = 0, 1, 2 counter-clockwise. Numbers with k = 3 stay unused,
// which saves a division by three in next and previous. Tables have 16-bit numbers if a patch has at most
// 16,383 faces, otherwise 32-bit numbers.
//
//            v                 opposite[c], o: the corner across the edge that is across from c
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

// The numbers at the corners of a face, and the unused fourth. Tables are aligned to 16 bytes, so a device
// loads or stores a row at once.
template <typename Index>
struct alignas(4 * sizeof(Index)) FaceRow {
  Index at[4];

  // The number at corner k, which is known only at run time. It is not loaded from memory.
  PSPLIT_HD uint32_t operator[](uint32_t k) const { return k == 0 ? at[0] : k == 1 ? at[1] : at[2]; }
};
template <typename Index>
PSPLIT_HD FaceRow<Index>& row_of(View<Index> table, uint32_t corner) {
  return *reinterpret_cast<FaceRow<Index>*>(&table[corner & ~3u]);
}

template <typename Index>
struct CornerTable {
  View<Index> opposite;  // kNone on a border, and on a seam if the table is an attribute's
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
