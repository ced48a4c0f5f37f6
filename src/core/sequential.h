// Faces of a sequential stream: each one as the numbers of its points. Draco bitstream specification 2.2,
// "sequential connectivity".
#pragma once

#include "src/core/patch.h"
#include "src/core/symbols.h"

namespace psplit::core {

// Decodes faces to patch.point_at. patch.face_count and patch.point_count are set.
template <typename Index>
PSPLIT_HD Fault decode_sequential_faces(ByteReader& reader, Arena& arena, Patch<Index>& patch) {
  const uint32_t index_count = 3 * patch.face_count, points = patch.point_count;
  if (!arena.take(patch.point_at, uint64_t{4} * patch.face_count)) return Fault::kWorkspace;
  bool in_range = true;
  const auto store = [&](uint32_t i, uint64_t point) {
    in_range &= point < points;
    patch.point_at[4 * (i / 3) + i % 3] = static_cast<Index>(point);
  };
  const uint8_t is_plain = reader.u8();
  if (is_plain == 0) {
    int64_t last = 0;
    const Fault fault = decode_symbols(reader, index_count, arena, [&](uint32_t i, uint32_t symbol) {
      last += (symbol & 1) != 0 ? -int64_t{symbol >> 1} : int64_t{symbol >> 1};
      if (last < 0) in_range = false, last = 0;
      store(i, static_cast<uint64_t>(last));
    });
    if (fault != Fault::kNone) return fault;
  } else {
    // The number of points decides how a point is stored.
    for (uint32_t i = 0; i < index_count && !reader.truncated(); ++i)
      store(i, points < 1u << 8    ? reader.u8()
               : points < 1u << 16 ? reader.u16()
               : points < 1u << 21 ? reader.varint()
                                   : reader.u32());
  }
  if (reader.truncated()) return Fault::kTruncated;
  return in_range ? Fault::kNone : Fault::kIndex;
}

// The memory that it takes and keeps, and the memory that it takes and releases; without the slots of a table.
template <typename Index>
PSPLIT_HD constexpr size_t sequential_bytes(uint32_t face_count) {
  return Arena::bytes<Index>(uint64_t{4} * face_count);
}
PSPLIT_HD constexpr size_t sequential_scratch_bytes(uint32_t face_count) {
  return decode_symbols_bytes(uint64_t{3} * face_count);
}

}  // namespace psplit::core
