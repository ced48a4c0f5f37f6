// A section of a condensed stream: 16-bit words for the entropy coder from the front, plain bits from the back.
//
// J. Duda: Asymmetric numeral systems, 2013. Specification: "sections"
// (gltf_ext/PSPLIT_mesh_draco_patches).
#pragma once

#include "src/core/byte_reader.h"
#include "src/core/condensed/models.h"
#include "src/core/fault.h"

namespace psplit::core {

PSPLIT_HD inline uint64_t load_be64(const uint8_t* bytes) { return bytes_reversed(load_words(bytes)); }

// Reads words and bits. Past the end of the section bits are 0 and words are the section's last one; is_at_end
// is false then. A load is always inside the section, so that the steps of a run need no checks.
class SectionReader {
 public:
  SectionReader() = default;
  // Only bits can be read before start_words.
  PSPLIT_HD SectionReader(const uint8_t* data, size_t size) : begin_(data), end_(data + size), at_(end_) {}

  // The section begins at byte `begin`, which is not beyond its end. Reads the coder's first state.
  PSPLIT_HD Fault start_words(size_t begin) {
    begin_ += begin;
    if (size() < 4) return Fault::kTruncated;
    state_ = load_le32(begin_);
    at_ = begin_ + 4;
    return Fault::kNone;
  }

  // Plain bits, as BitReader reads them.
  PSPLIT_HD PSPLIT_INLINE uint64_t peek(int) const {
    const uint64_t byte = taken_ / 8;
    if (PSPLIT_LIKELY(byte + 8 <= size() && byte + 1 > kMostBeyond))
      return load_be64(end_ - 8 - byte) >> taken_ % 8;
    return last_bits() >> taken_ % 8;
  }
  PSPLIT_HD PSPLIT_INLINE void take(int count) { taken_ += static_cast<uint64_t>(count); }
  PSPLIT_HD PSPLIT_INLINE uint32_t read(int count) {
    const auto value = static_cast<uint32_t>(peek(count) & ((uint64_t{1} << count) - 1));
    take(count);
    return value;
  }
  PSPLIT_HD bool empty() const { return begin_ == end_; }
  PSPLIT_HD uint64_t bits_taken() const { return taken_; }
  PSPLIT_HD uint32_t state() const { return state_; }
  PSPLIT_HD size_t word_bytes_taken() const { return static_cast<size_t>(at_ - begin_); }
  PSPLIT_HD void go_to_bit(uint64_t at) { taken_ = at; }
  PSPLIT_HD bool has_bits(uint64_t end) const { return end <= uint64_t{8} * size(); }

  // Entropy decoding: the slot of the next symbol, and the step after a symbol with this slot.
  PSPLIT_HD PSPLIT_INLINE uint32_t slot() const { return state_ % kSlots; }
  // `offset` is the place of the slot in the symbol. kIsFar: the section has another word.
  template <bool kIsFar = false>
  PSPLIT_HD PSPLIT_INLINE void leave(uint32_t frequency, uint32_t offset) {
    state_ = frequency * (state_ >> kSlotBits) + offset;
    // Whether a word is due is unpredictable.
    const uint32_t due = mask(state_ < kBase);
    const uint8_t* const last = end_ - 2;
    state_ = select(due, state_ << 16 | load_le16(kIsFar || at_ < last ? at_ : last), state_);
    at_ += 2 & due;
  }
  // Continues with words where a copy, which read no bits, is.
  PSPLIT_HD void go_to_words_of(const SectionReader& copy) { state_ = copy.state_, at_ = copy.at_; }
  // Whether that many words are left, which so many symbols may need.
  PSPLIT_HD bool has_words(uint32_t count) const { return int64_t{end_ - at_} >= int64_t{2} * count; }

  template <bool kIsFar = false>
  PSPLIT_HD PSPLIT_INLINE uint32_t next_token(const TokenTable& table) {
    const uint32_t at = slot(), token = table.token_of[at];
    const Share share = table.shares[token];
    leave<kIsFar>(share.frequency, at - share.first);
    return token;
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
    if (state_ != kBase || at_ > end_ || static_cast<uint64_t>(end_ - at_) != bytes) return false;
    const auto rest = static_cast<int>(bytes * 8 - taken_);
    return (peek(rest) & ((uint64_t{1} << rest) - 1)) == 0;
  }

 private:
  static constexpr uint32_t kBase = 1u << 16;

  PSPLIT_HD static uint32_t load_le16(const uint8_t* bytes) {
    uint16_t value;
    copy_bytes(&value, bytes, sizeof value);
    return value;
  }
  PSPLIT_HD uint64_t last_bits() const {
    uint64_t bits = 0;
    for (uint64_t i = 0, byte = taken_ / 8; i < 8 && byte + i < size(); ++i)
      bits |= uint64_t{*(end_ - 1 - (byte + i))} << 8 * i;
    return bits;
  }
  PSPLIT_HD size_t size() const { return static_cast<size_t>(end_ - begin_); }

  const uint8_t* begin_ = nullptr;
  const uint8_t* end_ = nullptr;
  const uint8_t* at_ = nullptr;  // the next word
  uint64_t taken_ = 0;           // bits
  uint32_t state_ = 0;
};

}  // namespace psplit::core
