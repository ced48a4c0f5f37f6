// Entropy decoding with asymmetric numeral systems: bits with one probability (rABS), and symbols with a table
// (rANS). Both read their bytes from the last to the first.
//
// J. Duda: Asymmetric numeral systems, 2013. Draco bitstream specification 2.2, "rANS decoding".
#pragma once

#include "src/core/byte_reader.h"
#include "src/core/fault.h"

namespace psplit::core {

// The state that the last bytes of a block hold: the top two bits of the very last say how many there are.
// Returns false where the block is too short, or the state is not below `base` * 256. `*size` becomes what is
// left.
PSPLIT_HD inline bool read_rans_state(const uint8_t* block, size_t* size, uint32_t base, uint32_t max_bytes,
                                      uint32_t* state) {
  if (*size == 0) return false;
  const uint32_t count = 1 + (block[*size - 1] >> 6);
  if (count > max_bytes || count > *size) return false;
  uint32_t value = 0;
  for (uint32_t i = 0; i < count; ++i) value = value << 8 | block[--*size];
  value &= (1u << (8 * count - 2)) - 1;
  *state = value + base;
  return *state < base * 256;
}

// A run of bits of which each is 0 with the same probability.
class RansBits {
 public:
  // Takes the block from the reader.
  PSPLIT_HD Fault start(ByteReader& reader) {
    prob_one_ = 256 - reader.u8();
    size_ = reader.varint();
    block_ = reader.head();
    if (!reader.skip(size_) || reader.truncated()) return Fault::kTruncated;
    return read_rans_state(block_, &size_, kBase, 3, &state_) ? Fault::kNone : Fault::kEntropy;
  }

  PSPLIT_HD bool next() {
    if (state_ < kBase && size_ > 0) state_ = state_ << 8 | block_[--size_];
    const uint32_t one = (state_ >> 8) * prob_one_, rest = state_ & 0xff;
    const bool bit = rest < prob_one_;
    state_ = bit ? one + rest : state_ - one - prob_one_;
    return bit;
  }

 private:
  static constexpr uint32_t kBase = 4096;
  const uint8_t* block_ = nullptr;
  size_t size_ = 0;
  uint32_t state_ = 0, prob_one_ = 0;
};

// A table of symbol probabilities that add up to 1 << precision_bits, and lookup in it.
//
// Each slot is a symbol, its probability and its first number. Up to kDirectBits every number has a slot of its
// own, so that one load decodes a symbol. Beyond, numbers are looked up by their top bits and the slots of the
// symbols are searched from there: a table of 2^20 entries would take longer to fill than a patch to decode.
class RansTable {
 public:
  struct Slot {
    uint32_t symbol;
    uint32_t prob;   // of 1 << precision_bits
    uint32_t first;  // sum of the probabilities of all lower symbols
  };

  static constexpr int kDirectBits = 12;  // the least precision there is

  // Reads the table. Slots live in the arena until it is released.
  PSPLIT_HD Fault read(ByteReader& reader, int precision_bits, Arena& arena) {
    precision_bits_ = precision_bits;
    lookup_shift_ = precision_bits > kDirectBits ? precision_bits - kDirectBits : 0;
    const uint32_t symbol_count = reader.varint();
    const uint32_t total = 1u << precision_bits;
    // One byte says at most that 64 symbols do not occur.
    if (reader.truncated()) return Fault::kTruncated;
    if (symbol_count == 0 || symbol_count / 64 > reader.remaining()) return Fault::kEntropy;
    if (!arena.take(lookup_, size_t{1} << (precision_bits - lookup_shift_))) return Fault::kWorkspace;
    // Symbols that occur have a slot each, and at least 1 of the total; one more slot ends the search.
    const uint32_t most = symbol_count < total ? symbol_count : total;
    if (lookup_shift_ > 0 && !arena.take(slots_, size_t{most} + 1)) return Fault::kWorkspace;
    uint32_t sum = 0, slot_count = 0, filled = 0;
    for (uint32_t symbol = 0; symbol < symbol_count; ++symbol) {
      const uint32_t byte = reader.u8();
      const uint32_t extra_bytes = byte & 3;
      if (extra_bytes == 3) {  // this and byte >> 2 more do not occur
        symbol += byte >> 2;
        if (symbol >= symbol_count) return Fault::kEntropy;
        continue;
      }
      uint32_t prob = byte >> 2;
      for (uint32_t i = 0; i < extra_bytes; ++i) prob |= static_cast<uint32_t>(reader.u8()) << (8 * i + 6);
      if (prob == 0) continue;
      if (prob > total - sum) return Fault::kEntropy;
      const Slot slot{symbol, prob, sum};
      sum += prob;
      if (lookup_shift_ == 0) {
        for (; filled < sum; ++filled) lookup_[filled] = direct_entry(slot, filled);
      } else {
        slots_[slot_count] = slot;
        // The first number of a bucket lies in this slot.
        for (; (filled << lookup_shift_) < sum; ++filled) lookup_[filled] = slot_count;
        ++slot_count;
      }
    }
    if (reader.truncated()) return Fault::kTruncated;
    return sum == total ? Fault::kNone : Fault::kEntropy;
  }

  PSPLIT_HD int precision_bits() const { return precision_bits_; }
  PSPLIT_HD bool is_direct() const { return lookup_shift_ == 0; }

  // What one number of a direct table decodes to: symbol, probability and offset in it, in 32 + 16 + 16 bits.
  PSPLIT_HD uint64_t direct(uint32_t number) const { return lookup_[number]; }

  PSPLIT_HD const Slot& search(uint32_t number) const {
    size_t slot = static_cast<size_t>(lookup_[number >> lookup_shift_]);
    while (number - slots_[slot].first >= slots_[slot].prob) ++slot;
    return slots_[slot];
  }

 private:
  PSPLIT_HD static uint64_t direct_entry(const Slot& slot, uint32_t number) {
    return uint64_t{slot.symbol} << 32 | slot.prob << 16 | (number - slot.first);
  }

  View<uint64_t> lookup_;
  View<Slot> slots_;
  int precision_bits_ = 0, lookup_shift_ = 0;
};

// A block of symbols.
class RansSymbols {
 public:
  PSPLIT_HD Fault start(ByteReader& reader, const RansTable& table) {
    base_ = 4u << table.precision_bits();
    const uint64_t size = reader.varint64();
    block_ = reader.head();
    if (!reader.skip(size) || reader.truncated()) return Fault::kTruncated;
    size_ = static_cast<size_t>(size);
    return read_rans_state(block_, &size_, base_, 4, &state_) ? Fault::kNone : Fault::kEntropy;
  }

  // One symbol, however the bytes end.
  PSPLIT_HD uint32_t next(const RansTable& table) {
    while (state_ < base_ && size_ > 0) state_ = state_ << 8 | block_[--size_];
    const uint32_t number = state_ & ((base_ >> 2) - 1), whole = state_ >> table.precision_bits();
    if (table.is_direct()) return step_direct(table.direct(number), whole);
    const RansTable::Slot& slot = table.search(number);
    state_ = slot.prob * whole + (number - slot.first);
    return slot.symbol;
  }

  // How many symbols next_fast may decode before it must be asked again: a step takes three bytes at most.
  PSPLIT_HD size_t fast_steps() const { return size_ / 3; }

  // One symbol of a direct table, without branches: how many bytes are due is as good as random. They are read
  // four at a time, which may touch what stands before the block: its own table does.
  PSPLIT_HD uint32_t next_fast(const RansTable& table) {
    // Of 12 bits' precision there are never three bytes due. The comparisons do not wait for each other.
    const uint32_t due = (state_ < kDirectBase) + (state_ < kDirectBase >> 8);
    const uint64_t ahead = uint64_t{state_} << 32 | load_le32(block_ + size_ - 4);
    state_ = static_cast<uint32_t>(ahead << 8 * due >> 32);
    size_ -= due;
    return step_direct(table.direct(state_ & (kDirectBase / 4 - 1)), state_ >> RansTable::kDirectBits);
  }

 private:
  static constexpr uint32_t kDirectBase = 4u << RansTable::kDirectBits;

  PSPLIT_HD uint32_t step_direct(uint64_t entry, uint32_t whole) {
    state_ = static_cast<uint32_t>(entry >> 16 & 0xffff) * whole + static_cast<uint32_t>(entry & 0xffff);
    return static_cast<uint32_t>(entry >> 32);
  }

  const uint8_t* block_ = nullptr;
  size_t size_ = 0;
  uint32_t state_ = 0, base_ = 0;
};

}  // namespace psplit::core
