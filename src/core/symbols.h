// Sequences of unsigned integers: Draco's two symbol codings.
//
//   raw     every value is one rANS symbol
//   tagged  for each group of components one rANS symbol says how many bits each of its values takes; the bits
//           follow in plain
#pragma once

#include "src/core/rans.h"

namespace psplit::core {

// A sequence whose table is read and whose entropy-coded symbols are not. Several may be decoded in step: one
// symbol of each in turn, so that none waits for its own last one (decode_in_step).
class SymbolSequence {
 public:
  // Values come in groups of `components`. Of no groups nothing at all is stored. The table lives in the arena.
  PSPLIT_HD Fault start(ByteReader& reader, uint32_t group_count, uint32_t components, Arena& arena) {
    group_count_ = group_count;
    components_ = components;
    if (group_count == 0) return Fault::kNone;
    constexpr uint8_t kTagged = 0, kRaw = 1;
    constexpr uint32_t kTagBits = 5, kMostSymbolBits = 18;
    const uint8_t coding = reader.u8();
    if (coding != kTagged && coding != kRaw) return reader.truncated() ? Fault::kTruncated : Fault::kMethod;
    is_tagged_ = coding == kTagged;
    const uint32_t symbol_bits = is_tagged_ ? kTagBits : reader.u8();
    if (symbol_bits == 0 || symbol_bits > kMostSymbolBits) return Fault::kEntropy;
    const uint32_t wanted = 3 * symbol_bits / 2;
    const int precision = static_cast<int>(wanted < 12 ? 12 : wanted > 20 ? 20 : wanted);
    const Fault fault = table_.read(reader, precision, arena);
    return fault == Fault::kNone ? symbols_.start(reader, table_) : fault;
  }

  // Decodes all values that are left: visit(i, value) for each. The reader stands where start left it, and then
  // behind the last value.
  template <typename Visit>
  PSPLIT_HD Fault decode(ByteReader& reader, Visit visit) {
    if (is_tagged_) return decode_tagged(reader, visit);
    const uint32_t count = value_count();
    while (done_ < count && table_.is_direct() && symbols_.fast_steps() > 0)
      for (uint32_t steps = fast_steps(); steps > 0; --steps, ++done_) visit(done_, symbols_.next_fast(table_));
    for (; done_ < count; ++done_) visit(done_, symbols_.next(table_));
    return Fault::kNone;
  }

  PSPLIT_HD uint32_t value_count() const { return group_count_ * components_; }
  // How many values next_fast may decode before it must be asked again; 0 where it must not be used any more.
  PSPLIT_HD uint32_t fast_steps() const {
    if (is_tagged_ || !table_.is_direct()) return 0;
    const size_t steps = symbols_.fast_steps(), left = value_count() - done_;
    return static_cast<uint32_t>(steps < left ? steps : left);
  }
  PSPLIT_HD uint32_t next_fast() { return symbols_.next_fast(table_); }
  PSPLIT_HD uint32_t done() const { return done_; }
  PSPLIT_HD void skip(uint32_t count) { done_ += count; }

 private:
  template <typename Visit>
  PSPLIT_HD Fault decode_tagged(ByteReader& reader, Visit visit) {
    BitReader bits(reader.head(), reader.remaining());
    uint32_t i = 0;
    for (uint32_t group = 0; group < group_count_; ++group) {
      const uint32_t bit_count = symbols_.next(table_);
      if (bit_count > 32) return Fault::kEntropy;
      for (uint32_t k = 0; k < components_; ++k) visit(i++, bits.read(static_cast<int>(bit_count)));
    }
    // Bits past the end read as 0, and are not there to be skipped.
    return reader.skip(bits.bytes_taken()) ? Fault::kNone : Fault::kTruncated;
  }

  RansTable table_;
  RansSymbols symbols_;
  uint32_t group_count_ = 0, components_ = 1, done_ = 0;
  bool is_tagged_ = false;
};

// Decodes a sequence at once; the arena is as before afterwards.
template <typename Visit>
PSPLIT_HD Fault decode_symbols(ByteReader& reader, uint32_t group_count, uint32_t components, Arena& arena,
                               Visit visit) {
  const size_t mark = arena.mark();
  SymbolSequence sequence;
  Fault fault = sequence.start(reader, group_count, components, arena);
  if (fault == Fault::kNone) fault = sequence.decode(reader, visit);
  arena.release(mark);
  return fault;
}

// 0, -1, 1, -2, 2 ... as 0, 1, 2, 3, 4 ...
PSPLIT_HD constexpr int32_t signed_of_symbol(uint32_t symbol) {
  return static_cast<int32_t>(symbol >> 1 ^ (0 - (symbol & 1)));
}

}  // namespace psplit::core
