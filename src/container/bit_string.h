// Strings of bits: numbers in the codes of src/core/stitch_codes.h, one after the other. Each byte is filled
// from its lowest bit up, and the unused bits of the last byte are 0. Specification: "Numbers of bits"
// (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include <bit>
#include <span>
#include <utility>
#include <vector>

#include "src/core/byte_reader.h"
#include "src/core/stitch_codes.h"

namespace psplit {

// Any bytes may be read. Past their end, and after a code that is too long, broken() holds and the results have
// no meaning.
class BitStringReader {
 public:
  explicit BitStringReader(std::span<const uint8_t> bytes)
      : bits_(bytes.data(), bytes.size()), size_(bytes.size()) {}

  // `count` is at most 32.
  uint32_t bits(int count) {
    const uint32_t value = bits_.read(count);
    is_broken_ |= bits_.bytes_taken() > size_;
    return value;
  }
  uint32_t number(core::NumberKind& kind) {
    uint32_t value;
    is_broken_ |= !core::read_number(bits_, kind, value) || bits_.bytes_taken() > size_;
    return value;
  }
  int64_t signed_number(core::NumberKind& kind) { return core::unfold(number(kind)); }

  bool broken() const { return is_broken_; }
  // Whether nothing is left but the unused bits of the last byte, which must be 0. Takes these.
  bool ends_here() {
    const int rest = static_cast<int>(bits_.bytes_taken() * 8 - bits_.bits_taken());
    return !is_broken_ && bits_.bytes_taken() == size_ && bits_.read(rest) == 0;
  }

 private:
  core::BitReader bits_;
  size_t size_;
  bool is_broken_ = false;
};

// LEB128, for bytes of another kind: the code of numbers in Draco streams, and of the lengths in a head.
inline void append_varint(uint64_t value, std::vector<uint8_t>& out) {
  for (; value >= 0x80; value >>= 7) out.push_back(static_cast<uint8_t>(value | 0x80));
  out.push_back(static_cast<uint8_t>(value));
}

class BitStringWriter {
 public:
  // The lowest `count` bits, at most 56.
  void bits(uint64_t value, uint32_t count) {
    pending_ |= (value & ((uint64_t{1} << count) - 1)) << pending_count_;
    for (pending_count_ += count; pending_count_ >= 8; pending_count_ -= 8, pending_ >>= 8)
      bytes_.push_back(static_cast<uint8_t>(pending_));
  }
  // `value` is below 2^32.
  void number(core::NumberKind& kind, uint64_t value) {
    const uint64_t high = (value >> kind.order()) + 1;
    const auto zeros = static_cast<uint32_t>(std::bit_width(high)) - 1;
    bits(uint64_t{1} << zeros, zeros + 1);
    bits(high, zeros);  // its highest bit is known
    bits(value, kind.order());
    kind.follow(static_cast<uint32_t>(value));
  }
  // -2^31 <= value < 2^31
  void signed_number(core::NumberKind& kind, int64_t value) { number(kind, core::fold(value)); }

  uint64_t bit_count() const { return 8 * uint64_t{bytes_.size()} + pending_count_; }
  std::vector<uint8_t> take() {
    if (pending_count_ > 0) bytes_.push_back(static_cast<uint8_t>(pending_));
    pending_ = 0, pending_count_ = 0;
    return std::exchange(bytes_, {});
  }

 private:
  std::vector<uint8_t> bytes_;
  uint64_t pending_ = 0;
  uint32_t pending_count_ = 0;  // below 8
};

}  // namespace psplit
