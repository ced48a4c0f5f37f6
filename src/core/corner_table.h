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
  const uint32_t c = corner;
  return static_cast<Index>((c & 2) != 0 ? c - 2 : c + 1);
}
template <typename Index>
PSPLIT_HD constexpr Index previous(Index corner) {
  const uint32_t c = corner;
  return static_cast<Index>((c & 3) != 0 ? c - 1 : c + 2);
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

// A value for each face, and one for the face that kNone names, so that no branch is needed at a border. With
// 16-bit numbers a corner is taken as signed: kNone is -1, and its face is -1 as well. The faces from 8,192 on
// become negative too. With 32-bit numbers the value of kNone comes after the values of all faces.
template <typename Index, typename T>
class FaceValues {
 public:
  PSPLIT_HD bool take(uint32_t face_count, Arena& arena) {
    if (!arena.take(values_, value_count(face_count))) return false;
    first_ = values_.data() + (kIsSigned ? before(face_count) : 0);
    none_ = kIsSigned ? ~uint32_t{0} : face_count;
    return true;
  }
  // The memory that `take` takes.
  PSPLIT_HD static constexpr size_t bytes(uint32_t face_count) {
    return Arena::bytes<T>(value_count(face_count));
  }
  PSPLIT_HD void give_back(Arena& arena) { arena.give_back(values_); }

  // All values; their order is not that of the faces.
  PSPLIT_HD View<T> all() const { return values_; }
  PSPLIT_HD T& of_none() const { return first_[kIsSigned ? -1 : static_cast<ptrdiff_t>(none_)]; }
  // The value of a corner's face. The corner is not kNone.
  PSPLIT_HD T& of_face(uint32_t corner) const { return first_[face_of(as_signed(corner))]; }
  // The value of the corner's face, or of kNone.
  PSPLIT_HD T& at(uint32_t corner) const { return at_signed(as_signed(corner)); }
  // at() in two steps. To sign a corner when it is loaded saves an instruction.
  PSPLIT_HD static ptrdiff_t as_signed(uint32_t corner) {
    if constexpr (kIsSigned) return static_cast<int16_t>(corner);
    return static_cast<ptrdiff_t>(corner);
  }
  PSPLIT_HD T& at_signed(ptrdiff_t corner) const {
    const ptrdiff_t face = face_of(corner);
    return first_[kIsSigned || face < static_cast<ptrdiff_t>(none_) ? face : static_cast<ptrdiff_t>(none_)];
  }

 private:
  static constexpr bool kIsSigned = sizeof(Index) == 2;
  static constexpr uint32_t kMostPositive = 8192;

  // With 32-bit numbers, kNone's face is beyond all others, also if ptrdiff_t has 32 bits.
  PSPLIT_HD static ptrdiff_t face_of(ptrdiff_t corner) {
    if constexpr (kIsSigned) return corner >> 2;
    return static_cast<ptrdiff_t>(static_cast<uint32_t>(corner) >> 2);
  }

  PSPLIT_HD static constexpr uint32_t before(uint32_t face_count) {
    return face_count > kMostPositive ? kMostPositive : 1;
  }
  PSPLIT_HD static constexpr size_t value_count(uint32_t face_count) {
    if (!kIsSigned) return size_t{face_count} + 1;
    return size_t{before(face_count)} + (face_count > kMostPositive ? kMostPositive : face_count);
  }

  View<T> values_;
  T* first_ = nullptr;  // of face 0
  uint32_t none_ = 0;   // with 32-bit numbers: the number of faces
};

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
