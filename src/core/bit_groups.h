// The values of tagged symbol sequences (symbols.h): groups of plain bits. The tag of a group is the number of
// bits of each of its values. All tags are decoded before, so a prefix sum says where each group starts, and
// each lane reads a group.
#pragma once

#include "src/core/byte_reader.h"
#include "src/core/fault.h"
#include "src/core/lanes.h"

namespace psplit::core {

// Reads at least 57 bits from bit `at` on. Bits past the end are 0.
PSPLIT_HD inline uint64_t bits_at(const uint8_t* data, size_t size, uint64_t at) {
  const uint64_t byte = at / 8;
  const int shift = static_cast<int>(at % 8);
  if (PSPLIT_LIKELY(byte < size && size - byte >= 8 + kMostBeyond)) return load_words(data + byte) >> shift;
  uint64_t bits = 0;
  for (uint64_t i = byte; i < size && i < byte + 8; ++i) bits |= uint64_t{data[i]} << 8 * (i - byte);
  return bits >> shift;
}

// Does the work of read_tagged. kComponents equals `components`, or is 0 for any number.
template <uint32_t kComponents, Lanes L>
PSPLIT_HD Fault read_groups(L lanes, ByteReader& reader, View<const uint32_t> tags, uint32_t components,
                            View<uint32_t> out) {
  constexpr uint32_t kMostBits = 32;
  if constexpr (kComponents != 0) components = kComponents;
  const uint8_t* data = reader.head();
  const size_t size = reader.remaining();
  const auto group_count = static_cast<uint32_t>(tags.size());
  uint64_t taken = 0;  // the bits of all chunks before
  for (uint32_t chunk = 0; chunk < group_count; chunk += L::size()) {
    const uint32_t group = chunk + lanes.rank();
    const uint32_t bit_count = group < group_count ? tags[group] : 0;
    if (PSPLIT_UNLIKELY(any(lanes, bit_count > kMostBits))) return Fault::kEntropy;
    const uint32_t together = bit_count * components;
    const Scan<uint32_t> scan = exclusive_scan(lanes, together);
    lanes.sync();  // the values of this chunk may overwrite its tags, never later ones
    if (group < group_count) {
      const uint64_t mask = (uint64_t{1} << bit_count) - 1;
      uint64_t at = taken + scan.before;
      uint32_t i = group * components;
      if (together <= 57) {
        uint64_t ahead = bits_at(data, size, at);
        for (uint32_t k = 0; k < components; ++k, ahead >>= bit_count)
          out[i++] = static_cast<uint32_t>(ahead & mask);
      } else {
        for (uint32_t k = 0; k < components; ++k, at += bit_count)
          out[i++] = static_cast<uint32_t>(bits_at(data, size, at) & mask);
      }
    }
    taken += scan.total;
  }
  lanes.sync();
  // Bits past the end were read as 0, but they cannot be skipped.
  return reader.skip((taken + 7) / 8) ? Fault::kNone : Fault::kTruncated;
}
// Decodes tags.size() groups of `components` values, at most 255, to `out`, which has room for all values.
// `tags` may be the end of `out`. Every lane has a reader of its own. All readers are at the same byte, and
// take the same bytes. A tag above 32 is a fault; `out` is undefined then.
template <Lanes L>
PSPLIT_HD Fault read_tagged(L lanes, ByteReader& reader, View<const uint32_t> tags, uint32_t components,
                            View<uint32_t> out) {
  if constexpr (L::size() == 1 && !PSPLIT_IS_SMALL_CODE) {
    // One thread is faster if it knows their number when it is compiled.
    if (components == 2) return read_groups<2>(lanes, reader, tags, components, out);
    if (components == 3) return read_groups<3>(lanes, reader, tags, components, out);
    if (components == 4) return read_groups<4>(lanes, reader, tags, components, out);
  }
  return read_groups<0>(lanes, reader, tags, components, out);
}

}  // namespace psplit::core
