// Sequences of unsigned integers: Draco's two symbol codings.
//
//   raw     every value is one rANS symbol
//   tagged  each group of components has a tag, which is one rANS symbol: the number of bits of each value
//           in the group. The values follow in plain bits.
#pragma once

#include "src/core/bit_groups.h"
#include "src/core/in_step.h"
#include "src/core/rans.h"

namespace psplit::core {

// A sequence whose table is read, and whose entropy-coded symbols are decoded later. Several sequences may be
// decoded in step, one symbol of each in turn, so that none waits for its own last symbol (step_symbols).
class SymbolSequence {
 public:
  // Values are in groups of `components`, and are written to `out`, which has room for all. The stream stores
  // nothing for a sequence without groups. The table is in the arena.
  PSPLIT_HD Fault start(ByteReader& reader, uint32_t group_count, uint32_t components, Arena& arena,
                        View<uint32_t> out) {
    group_count_ = group_count;
    components_ = components;
    out_ = out;
    if (group_count == 0) return Fault::kNone;
    constexpr uint8_t kTagged = 0, kRaw = 1;
    constexpr uint32_t kTagBits = 5, kMostSymbolBits = 18;
    const uint8_t coding = reader.u8();
    if (coding != kTagged && coding != kRaw) return reader.truncated() ? Fault::kTruncated : Fault::kMethod;
    is_tagged_ = coding == kTagged;
    // Tags are written to the places of the last values, and are read before those values are written.
    symbol_count_ = is_tagged_ ? group_count : group_count * components;
    first_ = group_count * components - symbol_count_;
    const uint32_t symbol_bits = is_tagged_ ? kTagBits : reader.u8();
    if (symbol_bits == 0 || symbol_bits > kMostSymbolBits) return Fault::kEntropy;
    const uint32_t wanted = 3 * symbol_bits / 2;
    const uint32_t precision = wanted < 12 ? 12 : wanted > 20 ? 20 : wanted;
    const Fault fault = table_.read(reader, precision, symbol_count_, arena);
    return fault == Fault::kNone ? symbols_.start(reader, table_) : fault;
  }

  // The memory that `start` takes for `count` sequences with `symbol_count` symbols together, without the slots
  // of the tables.
  PSPLIT_HD static constexpr size_t bytes(uint64_t count, uint64_t symbol_count) {
    return RansTable::bytes(count, symbol_count);
  }

  PSPLIT_HD bool is_tagged() const { return is_tagged_; }
  PSPLIT_HD bool is_direct() const { return table_.is_direct(); }
  PSPLIT_HD uint32_t steps_left() const { return symbol_count_ - done_; }
  // To be called before steps.
  PSPLIT_HD void fill_buckets() { table_.fill_buckets(); }
  template <Lanes L>
  PSPLIT_HD void fill_buckets(L lanes) {
    table_.fill_buckets(lanes);
  }

  // Decodes the symbols that are left.
  PSPLIT_HD void finish_symbols() {
    if (done_ < symbol_count_) table_.fill_buckets();
    for (; done_ < symbol_count_; ++done_) out_[first_ + done_] = symbols_.next(table_);
  }
  // Decodes the remaining symbols, and the values of tagged ones. The reader must be where start left it, and
  // is then after the last value. Collective: all lanes share the sequence and the reader.
  template <Lanes L>
  PSPLIT_HD Fault finish(L lanes, ByteReader& reader) {
    if (lanes.rank() == 0) finish_symbols();
    lanes.sync();
    if (!is_tagged_) return Fault::kNone;
    ByteReader bits = reader;
    const View<const uint32_t> tags(out_.data() + first_, group_count_);
    const Fault fault = read_tagged(lanes, bits, tags, components_, out_);
    lanes.sync();
    if (lanes.rank() == 0) reader = bits;
    lanes.sync();
    return fault;
  }

 protected:
  // The number of symbols that next_fast may decode before this must be asked again; 0 if it must not be used
  // any more.
  PSPLIT_HD uint32_t fast_steps() const {
    const size_t steps = symbols_.fast_steps(), left = symbol_count_ - done_;
    return static_cast<uint32_t>(steps < left ? steps : left);
  }
  // kDirect must be is_direct().
  template <bool kDirect>
  PSPLIT_HD void next_fast() {
    out_[first_ + done_++] = symbols_.next_fast<kDirect>(table_);
  }
  template <bool kDirect>
  PSPLIT_HD void next_four() {
    Four four;
    PSPLIT_UNROLL
    for (uint32_t& symbol : four.symbols) symbol = symbols_.next_fast<kDirect>(table_);
    uint32_t* const to = &out_[first_ + done_];
    done_ += 4;
    if (reinterpret_cast<uintptr_t>(to) % sizeof four == 0) {
      *reinterpret_cast<Four*>(to) = four;
      return;
    }
    PSPLIT_UNROLL
    for (uint32_t k = 0; k < 4; ++k) to[k] = four.symbols[k];
  }
  PSPLIT_HD uint32_t done() const { return done_; }

 private:
  struct alignas(16) Four {
    uint32_t symbols[4];
  };

  RansTable table_;
  RansSymbols symbols_;
  View<uint32_t> out_;
  uint32_t group_count_ = 0, components_ = 1, symbol_count_ = 0, first_ = 0, done_ = 0;
  bool is_tagged_ = false;
};

// Steps through a sequence as long as enough bytes are left for the steps not to count them. The sequence's
// finish decodes the rest. A device takes four symbols in a step, so that it stores them together.
template <bool kDirect>
class SymbolSteps : public SymbolSequence {
 public:
  SymbolSteps() = default;
  PSPLIT_HD explicit SymbolSteps(const SymbolSequence& sequence) : SymbolSequence(sequence) { renew(); }
  // The steps that are left before renew().
  PSPLIT_HD uint32_t steps_left() const { return (limit_ - done()) / (PSPLIT_MOVES_ROWS ? 4 : 1); }
  PSPLIT_HD void renew() { limit_ = done() + fast_steps(); }
  PSPLIT_HD void step() {
    if constexpr (PSPLIT_MOVES_ROWS)
      next_four<kDirect>();
    else
      next_fast<kDirect>();
  }

 private:
  uint32_t limit_ = 0;
};

// Two symbols a step.
template <bool kDirect>
class SymbolPairSteps : public SymbolSteps<kDirect> {
 public:
  using SymbolSteps<kDirect>::SymbolSteps;
  PSPLIT_HD uint32_t steps_left() const { return SymbolSteps<kDirect>::steps_left() / 2; }
  PSPLIT_HD void step() {
    SymbolSteps<kDirect>::step();
    SymbolSteps<kDirect>::step();
  }
};

// Calls take_direct(runs, count) and take_wide(runs, count) for the sequences with tables of each kind.
template <typename TakeDirect, typename TakeWide>
PSPLIT_HD void for_tables(SymbolSequence* const* sequences, uint32_t count, TakeDirect take_direct,
                          TakeWide take_wide) {
  constexpr uint32_t kMost = 16;
  SymbolSequence *direct[kMost] = {}, *wide[kMost] = {};
  for (uint32_t i = 0; i < count;) {
    uint32_t direct_count = 0, wide_count = 0;
    for (; i < count && direct_count < kMost && wide_count < kMost; ++i) {
      sequences[i]->fill_buckets();
      if (sequences[i]->is_direct())
        direct[direct_count++] = sequences[i];
      else
        wide[wide_count++] = sequences[i];
    }
    take_direct(direct, direct_count);
    take_wide(wide, wide_count);
  }
}
// Takes the steps of all sequences, kRuns of them in turn. A device also finishes their symbols.
template <uint32_t kRuns>
PSPLIT_HD void step_symbols(SymbolSequence* const* sequences, uint32_t count) {
  for_tables(sequences, count, step_all<kRuns, SymbolSteps<true>, SymbolSequence>,
             step_all<kRuns, SymbolSteps<false>, SymbolSequence>);
  // A device has threads for these, too.
  if constexpr (PSPLIT_MOVES_ROWS)
    for (uint32_t i = 0; i < count; ++i) sequences[i]->finish_symbols();
}

// Decodes a sequence of single values, and calls visit(i, value) for each. On success the arena is as before
// afterwards.
template <typename Visit>
PSPLIT_HD Fault decode_symbols(ByteReader& reader, uint32_t count, Arena& arena, Visit visit) {
  const size_t mark = arena.mark();
  View<uint32_t> values;
  if (!arena.take(values, count)) return Fault::kWorkspace;
  SymbolSequence sequence;
  Fault fault = sequence.start(reader, count, 1, arena, values);
  if (fault == Fault::kNone) {
    SymbolSequence* const one = &sequence;
    step_symbols<1>(&one, 1);
    fault = sequence.finish(SerialLanes(), reader);
  }
  if (fault != Fault::kNone) return fault;
  for (uint32_t i = 0; i < count; ++i) visit(i, values[i]);
  arena.release(mark);
  return Fault::kNone;
}

// The memory that decode_symbols takes and releases, without the slots of the table.
PSPLIT_HD constexpr size_t decode_symbols_bytes(uint64_t count) {
  return Arena::bytes<uint32_t>(count) + SymbolSequence::bytes(1, count);
}

}  // namespace psplit::core
