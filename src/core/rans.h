// Entropy decoding with asymmetric numeral systems: bits that share one probability (rABS), and symbols whose
// probabilities are in a table (rANS). Both read their bytes from the last to the first.
//
// J. Duda: Asymmetric numeral systems, 2013. Draco bitstream specification 2.2, "rANS decoding".
#pragma once

#include "src/core/byte_reader.h"
#include "src/core/fault.h"
#include "src/core/lanes.h"

namespace psplit::core {

// Reads the state from the last bytes of a block; the top two bits of the very last byte say how many bytes
// these are. `*size` becomes the number of bytes before them. Returns false if the block is too short, or if
// the state is not below `base` * 256.
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

// A run of bits, each of which is 0 with the same probability.
class RansBits {
 public:
  // Takes the block from the reader.
  PSPLIT_HD Fault start(ByteReader& reader) {
    prob_one_ = (256u - reader.u8()) & 0xff;  // libdraco keeps it in a byte
    size_ = reader.varint();
    block_ = reader.head();
    if (!reader.skip(size_) || reader.truncated()) return Fault::kTruncated;
    return read_rans_state(block_, &size_, kBase, 3, &state_) ? Fault::kNone : Fault::kEntropy;
  }

  // Whether the bits that are left equal the bits that are left of another run.
  PSPLIT_HD bool is_same(const RansBits& other) const {
    return prob_one_ == other.prob_one_ && state_ == other.state_ && size_ == other.size_ &&
           (size_ == 0 || equal_bytes(block_, other.block_, size_));
  }

  PSPLIT_HD bool next() {
    if (state_ < kBase && size_ > 0) state_ = state_ << 8 | block_[--size_];
    const uint32_t one = (state_ >> 8) * prob_one_, rest = state_ & 0xff;
    const bool bit = rest < prob_one_;
    state_ = bit ? one + rest : state_ - one - prob_one_;
    return bit;
  }

  // Like next(), but without a branch for the bit, which is unpredictable. That a byte is due is not: the bits
  // of most runs are mostly alike, and take far less than a bit of the state. A device has no branch for it
  // either, and may load the byte before the block, which exists: the last byte of the block's length.
  PSPLIT_HD uint32_t next_fast() {
    if constexpr (PSPLIT_MOVES_ROWS) {
      const uint32_t due = mask(state_ < kBase) & mask(size_ > 0);
      state_ = select(due, state_ << 8 | *(block_ + size_ - 1), state_);
      size_ -= due & 1;
    } else if (PSPLIT_UNLIKELY(state_ < kBase) && size_ > 0) {
      state_ = state_ << 8 | block_[--size_];
    }
    const uint32_t one = (state_ >> 8) * prob_one_, rest = state_ & 0xff, bit = mask(rest < prob_one_);
    state_ = select(bit, one + rest, state_ - one - prob_one_);
    return bit & 1;
  }

 private:
  static constexpr uint32_t kBase = 4096;
  const uint8_t* block_ = nullptr;
  size_t size_ = 0;
  uint32_t state_ = 0, prob_one_ = 0;
};

// Decodes the bits of one run, and writes each as a byte.
class BitSteps {
 public:
  BitSteps() = default;
  PSPLIT_HD BitSteps(RansBits bits, View<uint8_t> out)
      : bits_(bits), at_(out.data()), end_(out.data() + out.size()) {}
  PSPLIT_HD uint32_t steps_left() const { return static_cast<uint32_t>(end_ - at_); }
  PSPLIT_HD void step() { *at_++ = static_cast<uint8_t>(bits_.next_fast()); }

 private:
  RansBits bits_;
  uint8_t* at_ = nullptr;
  uint8_t* end_ = nullptr;
};

// A table of symbol probabilities, which add up to 1 << precision_bits, and the search for the symbol that a
// number below that sum stands for.
//
// With kDirectBits of precision each number has an entry of its own, so that one load decodes a symbol. With
// more precision, or for few symbols, the top bits of a number select a bucket, which says at which slot to
// begin a search; the first slot is nearly always the right one. A table of 2^20 entries would take longer to
// fill than a patch to decode, and one of 2^12 entries longer than some hundred symbols. A device has few bytes
// of cache for each of its many tables, so it always searches.
class RansTable {
 public:
  static constexpr uint32_t kDirectBits = 12;  // the lowest precision
  static constexpr uint32_t kFew = 1024, kFewBits = 8, kDeviceBits = 10;

  // A symbol, its probability as a part of 1 << precision_bits, and the sum of the probabilities of all lower
  // symbols.
  class Slot {
   public:
    static constexpr uint32_t kMostSymbols = 1u << 24;

    Slot() = default;
    PSPLIT_HD Slot(uint32_t symbol, uint32_t prob, uint32_t first)
        : packed_(uint64_t{symbol} << 40 | uint64_t{prob - 1} << 20 | first) {}
    PSPLIT_HD uint32_t symbol() const { return static_cast<uint32_t>(packed_ >> 40); }
    PSPLIT_HD uint32_t prob() const { return (static_cast<uint32_t>(packed_ >> 20) & 0xfffff) + 1; }
    PSPLIT_HD uint32_t first() const { return static_cast<uint32_t>(packed_) & 0xfffff; }

   private:
    uint64_t packed_;
  };

  // Reads the table with which `count` symbols are coded. Its arrays are in the arena. Does not fill buckets:
  // each thread of a device that decodes symbols fills its own buckets.
  PSPLIT_HD Fault read(ByteReader& reader, uint32_t precision_bits, uint32_t count, Arena& arena) {
    precision_bits_ = precision_bits;
    is_direct_ = precision_bits == kDirectBits && count >= kFew;
    const uint32_t bucket_bits = count < kFew ? kFewBits : PSPLIT_MOVES_ROWS ? kDeviceBits : kDirectBits;
    bucket_shift_ = precision_bits - bucket_bits;
    const uint32_t symbol_count = reader.varint();
    const uint32_t total = 1u << precision_bits;
    // One byte can say that 64 symbols do not occur, but no more.
    if (reader.truncated()) return Fault::kTruncated;
    if (symbol_count == 0 || symbol_count / 64 > reader.remaining() || symbol_count > Slot::kMostSymbols)
      return Fault::kEntropy;
    // A symbol that occurs has a slot. It takes at least 1 of the total, and at least one byte of the stream.
    const uint32_t most = symbol_count < total ? symbol_count : total;
    const size_t most_slots = most < reader.remaining() ? most : reader.remaining();
    // An encoder writes only symbols that occur.
    if (is_direct() ? !arena.take(direct_, size_t{1} << kDirectBits)
                    : !arena.take(buckets_, size_t{1} << bucket_bits) ||
                          !arena.take(slots_, most_slots < count ? most_slots : count))
      return Fault::kWorkspace;
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
      if (is_direct()) {
        uint64_t entry = uint64_t{symbol} << 32 | prob << 16;
        for (const uint32_t end = sum + prob; filled < end; ++filled, ++entry) direct_[filled] = entry;
      } else {
        if (PSPLIT_UNLIKELY(slot_count == slots_.size())) {
          arena.trim(slots_, 0);  // grows where it is
          if (!arena.take(slots_, most_slots)) return Fault::kWorkspace;
        }
        slots_[slot_count++] = {symbol, prob, sum};
      }
      sum += prob;
    }
    if (reader.truncated()) return Fault::kTruncated;
    if (!is_direct()) arena.trim(slots_, slot_count);
    return sum == total ? Fault::kNone : Fault::kEntropy;
  }

  // To be called before the first number is looked up.
  PSPLIT_HD void fill_buckets() {
    if (is_direct() || is_filled_) return;
    is_filled_ = true;
    uint32_t filled = 0;
    for (uint32_t slot = 0; slot < slots_.size(); ++slot) {
      // The first number of these buckets is in this slot.
      const uint32_t end = slots_[slot].first() + slots_[slot].prob();
      for (; filled << bucket_shift_ < end; ++filled) buckets_[filled] = slot;
    }
  }

  // Fills buckets by all lanes together. Collective: all lanes share the table.
  template <Lanes L>
  PSPLIT_HD void fill_buckets(L lanes) {
    const bool is_due = !is_direct() && !is_filled_ && !slots_.empty();
    lanes.sync();
    if (!is_due) return;
    const View<const Slot> slots = slots_;
    const View<uint32_t> buckets = buckets_;
    const uint32_t shift = bucket_shift_;
    for_each_lane_item(lanes, static_cast<uint32_t>(buckets.size()), [&](uint32_t bucket) {
      // The last slot that does not begin after the bucket's first number.
      uint32_t low = 0;
      for (uint32_t count = static_cast<uint32_t>(slots.size()); count > 1;) {
        const uint32_t half = count / 2;
        if (slots[low + half].first() <= bucket << shift) low += half;
        count -= half;
      }
      buckets[bucket] = low;
    });
    if (lanes.rank() == 0) is_filled_ = true;
    lanes.sync();
  }

  // The memory that `read` takes for `table_count` tables of `symbol_count` symbols together, without the
  // slots.
  PSPLIT_HD static constexpr size_t bytes(uint64_t table_count, uint64_t symbol_count) {
    const uint64_t most_large = symbol_count / kFew,
                   large = most_large < table_count ? most_large : table_count;
    return static_cast<size_t>(large * Arena::bytes<uint64_t>(uint64_t{1} << kDirectBits) +
                               (table_count - large) * Arena::bytes<uint32_t>(uint64_t{1} << kFewBits) +
                               table_count * Arena::bytes<Slot>(0));
  }
  // All slots of all tables that an encoder writes to a stream, for `symbol_count` symbols together: one for
  // each symbol that occurs, and each takes a byte of the stream.
  PSPLIT_HD static constexpr size_t slot_bytes(uint64_t symbol_count, uint64_t stream_bytes) {
    return Arena::bytes<Slot>(symbol_count < stream_bytes ? symbol_count : stream_bytes);
  }
  // The bytes of slots if there is one table, and `read` is over. The entropy of n symbols, k of them
  // different, is at least (k - 1) log2(n) bits: k - 1 of them occur once in the case that takes the fewest.
  PSPLIT_HD static constexpr size_t slot_bytes_of_one(uint64_t symbol_count, uint64_t stream_bytes) {
    uint32_t log = 0;
    for (uint32_t step = 32; step > 0; step /= 2)
      if (symbol_count >> log >> step > 0) log += step;
    return slot_bytes(symbol_count, 8 * stream_bytes / (8 + log) + 1);
  }

  PSPLIT_HD uint32_t precision_bits() const { return precision_bits_; }
  // Never for devices: their compiler then leaves out all that direct tables need.
  PSPLIT_HD bool is_direct() const { return !PSPLIT_MOVES_ROWS && is_direct_; }

  // The entry of a number in a direct table: its symbol, the symbol's probability, and the number's offset in
  // it, in 32 + 16 + 16 bits.
  PSPLIT_HD uint64_t direct(uint32_t number) const { return direct_[number]; }

  PSPLIT_HD Slot search(uint32_t number) const {
    size_t at = buckets_[number >> bucket_shift_];
    Slot slot = slots_[at];
    while (PSPLIT_UNLIKELY(number - slot.first() >= slot.prob())) slot = slots_[++at];
    return slot;
  }

 private:
  View<uint64_t> direct_;
  View<uint32_t> buckets_;
  View<Slot> slots_;
  uint32_t precision_bits_ = 0, bucket_shift_ = 0;
  bool is_direct_ = false, is_filled_ = false;
};

// The bytes before a place in a block, from the last to the first. For devices: it loads aligned words, each
// one word before it is needed, so that no symbol waits for its bytes. Small code has an empty one.
template <bool kIsUsed>
class BytesBefore {
 public:
  BytesBefore() = default;
  PSPLIT_HD BytesBefore(const uint8_t*, const uint8_t*) {}
  PSPLIT_HD uint32_t next_four() const { return 0; }
  PSPLIT_HD void take(uint32_t, const uint8_t*) {}
};
template <>
class BytesBefore<true> {
 public:
  BytesBefore() = default;
  // `end` is one past the last byte of the block. At least three bytes come before the block.
  PSPLIT_HD BytesBefore(const uint8_t* block, const uint8_t* end) {
    for (at_ = end; at_ > block && reinterpret_cast<uintptr_t>(at_) % sizeof word_ != 0; ++count_)
      bytes_ |= uint64_t{*--at_} << (56 - 8 * count_);
    load(block);
    fill_up(block);
  }
  // The next four bytes, the very next one on top; 0 for bytes before the block's.
  PSPLIT_HD uint32_t next_four() const { return static_cast<uint32_t>(bytes_ >> 32); }
  // Takes at most four.
  PSPLIT_HD void take(uint32_t count, const uint8_t* block) {
    bytes_ <<= 8 * count;
    count_ -= count;
    if (count_ < 4) fill_up(block);
  }

 private:
  PSPLIT_HD void fill_up(const uint8_t* block) {
    if (count_ >= 4) return;
    bytes_ |= uint64_t{word_} << (32 - 8 * count_);
    count_ += 4;
    load(block);
  }
  PSPLIT_HD void load(const uint8_t* block) {
    word_ = 0;
    if (at_ <= block) return;
    at_ -= sizeof word_;
    word_ = *reinterpret_cast<const uint32_t*>(at_);
  }

  uint64_t bytes_ = 0;  // from the top on
  const uint8_t* at_ = nullptr;
  uint32_t word_ = 0, count_ = 0;  // the word before those bytes; the number of bytes
};

// A block of symbols.
class RansSymbols {
  using Before = BytesBefore<!PSPLIT_IS_SMALL_CODE>;

 public:
  PSPLIT_HD Fault start(ByteReader& reader, const RansTable& table) {
    base_ = 4u << table.precision_bits();
    const uint64_t size = reader.varint64();
    block_ = reader.head();
    if (!reader.skip(size) || reader.truncated()) return Fault::kTruncated;
    size_ = static_cast<size_t>(size);
    if (!read_rans_state(block_, &size_, base_, 4, &state_)) return Fault::kEntropy;
    if constexpr (PSPLIT_MOVES_ROWS) before_ = Before(block_, block_ + size_);
    return Fault::kNone;
  }

  // Decodes one symbol, however few bytes are left. next_fast must not follow.
  PSPLIT_HD uint32_t next(const RansTable& table) {
    while (state_ < base_ && size_ > 0) state_ = state_ << 8 | block_[--size_];
    return table.is_direct() ? step<true>(table) : step<false>(table);
  }

  // The number of symbols that next_fast may decode before this must be asked again: a symbol takes at most
  // three bytes. A device checks for bytes at each symbol instead, because lanes would wait for a slow last
  // loop.
  PSPLIT_HD size_t fast_steps() const { return PSPLIT_MOVES_ROWS ? ~size_t{0} : size_ / 3; }

  // Decodes one symbol without branches, except for a rare search: the number of bytes that are due is
  // unpredictable. Always loads four bytes, which may begin before the block. There are bytes: its own table's.
  template <bool kDirect>
  PSPLIT_HD uint32_t next_fast(const RansTable& table) {
    // The comparisons do not wait for each other. With 12 bits of precision three bytes are never due.
    uint32_t due = (state_ < base_) + (state_ < base_ >> 8);
    if constexpr (!kDirect) due += state_ < base_ >> 16;
    if constexpr (PSPLIT_MOVES_ROWS) due = due < size_ ? due : static_cast<uint32_t>(size_);
    const uint64_t ahead =
        uint64_t{state_} << 32 | (PSPLIT_MOVES_ROWS ? before_.next_four() : load_le32(block_ + size_ - 4));
    state_ = static_cast<uint32_t>(ahead << 8 * due >> 32);
    size_ -= due;
    if constexpr (PSPLIT_MOVES_ROWS) before_.take(due, block_);
    return step<kDirect>(table);
  }

 private:
  template <bool kDirect>
  PSPLIT_HD uint32_t step(const RansTable& table) {
    if constexpr (kDirect) {
      constexpr uint32_t kTotal = 1u << RansTable::kDirectBits;
      const uint64_t entry = table.direct(state_ % kTotal);
      state_ = static_cast<uint32_t>(entry >> 16 & 0xffff) * (state_ / kTotal) +
               static_cast<uint32_t>(entry & 0xffff);
      return static_cast<uint32_t>(entry >> 32);
    } else {
      const uint32_t number = state_ & ((1u << table.precision_bits()) - 1);
      const RansTable::Slot slot = table.search(number);
      state_ = slot.prob() * (state_ >> table.precision_bits()) + (number - slot.first());
      return slot.symbol();
    }
  }

  const uint8_t* block_ = nullptr;
  size_t size_ = 0;
  uint32_t state_ = 0, base_ = 0;
  [[no_unique_address]] Before before_;
};

}  // namespace psplit::core
