// A section of a condensed stream: 16-bit words for the entropy coder from the front, plain bits from the back.
//
// J. Duda: Asymmetric numeral systems, 2013. Specification: "sections"
// (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include "src/core/byte_reader.h"
#include "src/core/condensed/models.h"
#include "src/core/fault.h"

namespace psplit::core {

PSPLIT_HD inline uint64_t load_be64(const uint8_t* bytes) {
  const uint64_t value = load_le64(bytes);
#if defined(__CUDA_ARCH__)
  return uint64_t{__byte_perm(static_cast<uint32_t>(value), 0, 0x0123)} << 32 |
         __byte_perm(static_cast<uint32_t>(value >> 32), 0, 0x0123);
#else
  return __builtin_bswap64(value);
#endif
}

// Reads words and bits. Past the end of the section bits are 0 and words are the section's last one; is_at_end
// is false then. A load is always inside the section, so that the steps of a run need no checks.
class SectionReader {
 public:
  SectionReader() = default;
  // Only bits can be read before start_words.
  PSPLIT_HD SectionReader(const uint8_t* data, size_t size) : data_(data), size_(size) {}

  // The section begins at byte `begin`, which is not beyond its end. Reads the coder's first state.
  PSPLIT_HD Fault start_words(size_t begin) {
    data_ += begin;
    size_ -= begin;
    if (size_ < 4) return Fault::kTruncated;
    state_ = load_le32(data_);
    at_ = 4;
    return Fault::kNone;
  }

  // Plain bits, as BitReader reads them.
  PSPLIT_HD PSPLIT_INLINE uint64_t peek(int) const {
    const uint64_t byte = taken_ / 8;
    if (PSPLIT_LIKELY(byte + 8 <= size_))
      return load_be64(data_ + (size_ - 8 - static_cast<size_t>(byte))) >> taken_ % 8;
    return last_bits() >> taken_ % 8;
  }
  PSPLIT_HD PSPLIT_INLINE void take(int count) { taken_ += static_cast<uint64_t>(count); }
  PSPLIT_HD PSPLIT_INLINE uint32_t read(int count) {
    const auto value = static_cast<uint32_t>(peek(count) & ((uint64_t{1} << count) - 1));
    take(count);
    return value;
  }
  PSPLIT_HD bool empty() const { return size_ == 0; }
  PSPLIT_HD uint64_t bits_taken() const { return taken_; }
  PSPLIT_HD void go_to_bit(uint64_t at) { taken_ = at; }
  PSPLIT_HD bool has_bits(uint64_t end) const { return end <= uint64_t{8} * size_; }

  // Entropy decoding: the slot of the next symbol, and the step behind a symbol with this slot.
  PSPLIT_HD PSPLIT_INLINE uint32_t slot() const { return state_ % kSlots; }
  // `offset` is the place of the slot in the symbol.
  PSPLIT_HD PSPLIT_INLINE void leave(uint32_t frequency, uint32_t offset) {
    state_ = frequency * (state_ >> kSlotBits) + offset;
    // How often a word is due is unpredictable.
    const uint32_t due = mask(state_ < kBase);
    const size_t last = size_ - 2, from = at_ < last ? at_ : last;
    state_ = select(due, state_ << 16 | load_le16(data_ + from), state_);
    at_ += 2 & due;
  }

  PSPLIT_HD PSPLIT_INLINE uint32_t next_token(const TokenEntry* table) {
    const TokenEntry entry = table[slot()];
    leave((entry >> 20) + 1, entry % kSlots);
    return entry >> kSlotBits & 0xff;
  }
  // A decision with this probability of 1.
  PSPLIT_HD PSPLIT_INLINE uint32_t next_bit(uint32_t probability) {
    const uint32_t at = slot(), bit = mask(at < probability);
    leave(select(bit, probability, kSlots - probability), at - (probability & ~bit));
    return bit & 1;
  }

  // Whether words and bits fill the section, as an encoder left it.
  PSPLIT_HD bool is_at_end() const {
    const uint64_t bytes = (taken_ + 7) / 8;
    if (state_ != kBase || at_ > size_ || size_ - at_ != bytes) return false;
    const auto rest = static_cast<int>(bytes * 8 - taken_);
    return (peek(rest) & ((uint64_t{1} << rest) - 1)) == 0;
  }

 private:
  static constexpr uint32_t kBase = 1u << 16;

  PSPLIT_HD static uint32_t load_le16(const uint8_t* bytes) {
    uint16_t value;
    __builtin_memcpy(&value, bytes, sizeof value);
    return value;
  }
  PSPLIT_HD uint64_t last_bits() const {
    uint64_t bits = 0;
    for (uint64_t i = 0, byte = taken_ / 8; i < 8 && byte + i < size_; ++i)
      bits |= uint64_t{data_[size_ - 1 - static_cast<size_t>(byte + i)]} << 8 * i;
    return bits;
  }

  const uint8_t* data_ = nullptr;
  size_t size_ = 0, at_ = 0;
  uint64_t taken_ = 0;  // bits
  uint32_t state_ = 0;
};

}  // namespace psplit::core
