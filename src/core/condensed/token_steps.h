// The values of an attribute of a condensed stream: symbols as tokens. A small symbol is a token of its own. A
// larger one is a token for its two highest bits, and plain bits.
#pragma once

#include "src/core/condensed/section.h"
#include "src/core/in_step.h"

namespace psplit::core {

// A symbol is `base` plus the number in `bit_count` plain bits. `mask` has as many ones.
struct alignas(16) TokenBits {
  uint32_t base, bit_count, mask;
};
inline constexpr uint32_t kDirectTokens = 64, kFewestTokenBits = 5;
PSPLIT_HD constexpr TokenBits token_bits(uint32_t token) {
  if (token < kDirectTokens) return {token, 0, 0};
  const uint32_t bit_count = (token - kDirectTokens) / 2 + kFewestTokenBits;
  return {(2 + token % 2) << bit_count, bit_count, (1u << bit_count) - 1};
}

struct TokenBitsTable {
  constexpr TokenBitsTable() {
    for (uint32_t token = 0; token < kTokenCount; ++token) of[token] = token_bits(token);
  }
  TokenBits of[128] = {};  // all numbers that an entry of a token table can hold
};
inline constexpr TokenBitsTable kTokenBits;

PSPLIT_HD inline TokenBits bits_of_token(uint32_t token) {
#if PSPLIT_MOVES_ROWS
  return token_bits(token);
#else
  return kTokenBits.of[token];
#endif
}

// The symbol of a token, with its plain bits.
PSPLIT_HD PSPLIT_INLINE uint32_t symbol_of_token(SectionReader& section, uint32_t token) {
  if (PSPLIT_LIKELY(token < kDirectTokens)) return token;
  const TokenBits bits = bits_of_token(token);
  return bits.base + section.read(static_cast<int>(bits.bit_count));
}

// The symbols of one attribute, which are decoded later. Several sequences may be decoded in step.
class TokenSequence {
 public:
  // `table_of` has a number of one of the set's tables for each value: those tables exist. `out` has room for
  // the symbols of all values.
  PSPLIT_HD void start(const SectionReader& section, const CondensedModels& models, const TableSet& set,
                       uint32_t components, View<const uint8_t> table_of, View<uint32_t> out) {
    section_ = section;
    components_ = components;
    for (uint32_t i = 0; i < TableSet::kTables; ++i)
      tables_[i] = set.tables[i] == kNoTable ? nullptr : &models.token_tables[set.tables[i]];
    table_of_ = table_of.data();
    end_ = table_of_ + table_of.size();
    value_count_ = static_cast<uint32_t>(table_of.size());
    out_ = out.data();
  }
  PSPLIT_HD uint32_t components() const { return components_; }
  // The section after the tokens, once all steps were taken.
  PSPLIT_HD SectionReader& section() { return section_; }
  PSPLIT_HD uint32_t steps_left() const { return static_cast<uint32_t>(end_ - table_of_); }

  // Turns the tokens into symbols, after all steps. The lengths of bits are no chain as long as that of tokens.
  PSPLIT_HD void add_bits() {
    if constexpr (PSPLIT_MOVES_ROWS) return;
    SectionReader section = section_;  // stays in registers
    uint32_t* const end = out_;
    uint32_t* at = end - size_t{components_} * value_count_;
    for (; static_cast<size_t>(end - at) >= kTogether; at += kTogether) {
      TokenBits bits[kTogether];
      uint32_t together = 0;
      PSPLIT_UNROLL
      for (uint32_t k = 0; k < kTogether; ++k) {
        bits[k] = bits_of_token(at[k]);
        together += bits[k].bit_count;
      }
      if (PSPLIT_UNLIKELY(together > kMostBits)) {
        add_bits_alone(section, at, kTogether);
        continue;
      }
      uint64_t ahead = section.peek(kMostBits);
      section.take(static_cast<int>(together));
      PSPLIT_UNROLL
      for (uint32_t k = 0; k < kTogether; ++k) {
        at[k] = bits[k].base + (static_cast<uint32_t>(ahead) & bits[k].mask);
        ahead >>= bits[k].bit_count;
      }
    }
    add_bits_alone(section, at, static_cast<uint32_t>(end - at));
    section_ = section;
  }

 protected:
  // Stores the first decoded value: a token, or on a device the whole symbol.
  PSPLIT_HD PSPLIT_INLINE void put(uint32_t token) {
    if constexpr (PSPLIT_MOVES_ROWS) {
      const TokenBits bits = bits_of_token(token);
      *out_++ = bits.base + (bits.bit_count > 0 ? section_.read(static_cast<int>(bits.bit_count)) : 0);
    } else {
      *out_++ = token;
    }
  }

  SectionReader section_;
  uint32_t components_ = 0, value_count_ = 0;
  const TokenTable* tables_[TableSet::kTables] = {};
  const uint8_t* table_of_ = nullptr;
  const uint8_t* end_ = nullptr;
  uint32_t* out_ = nullptr;

 private:
  // The bits of several symbols come with one load, if it has them all.
  static constexpr uint32_t kTogether = 3;
  static constexpr int kMostBits = 56;

  PSPLIT_HD static void add_bits_alone(SectionReader& section, uint32_t* at, uint32_t count) {
    for (uint32_t k = 0; k < count; ++k) {
      const TokenBits bits = bits_of_token(at[k]);
      at[k] = bits.base + section.read(static_cast<int>(bits.bit_count));
    }
  }
};

// Decodes the tokens of one value a step, to the places of its symbols. kComponents is 0 if their number is
// known only at run time.
template <uint32_t kComponents>
class TokenSteps : public TokenSequence {
 public:
  static constexpr uint32_t kParts = kComponents;

  TokenSteps() = default;
  PSPLIT_HD explicit TokenSteps(const TokenSequence& sequence) : TokenSequence(sequence) {}

  PSPLIT_HD PSPLIT_INLINE void begin_step() { table_ = tables_[*table_of_++]; }
  PSPLIT_HD PSPLIT_INLINE void step_part() { put(section_.next_token(*table_)); }

 private:
  const TokenTable* table_ = nullptr;
};
template <>
class TokenSteps<0> : public TokenSequence {
 public:
  TokenSteps() = default;
  PSPLIT_HD explicit TokenSteps(const TokenSequence& sequence) : TokenSequence(sequence) {}

  PSPLIT_HD PSPLIT_INLINE void step() {
    const TokenTable& table = *tables_[*table_of_++];
    for (uint32_t k = 0; k < components_; ++k) put(section_.next_token(table));
  }
};

// Takes the steps of all sequences, at most 16, kRuns of them in turn.
template <uint32_t kRuns>
PSPLIT_HD void step_tokens(TokenSequence* const* sequences, uint32_t count) {
  constexpr uint32_t kMost = 16;
  const auto step_those = [&]<uint32_t kComponents>() {
    TokenSequence* chosen[kMost] = {};
    uint32_t chosen_count = 0;
    for (uint32_t i = 0; i < count && chosen_count < kMost; ++i) {
      const uint32_t components = sequences[i]->components(),
                     fast = components == 2 || components == 3 ? components : 0;
      if (fast == kComponents) chosen[chosen_count++] = sequences[i];
    }
    step_all<kComponents == 0 ? kRareInStep<kRuns> : kRuns, TokenSteps<kComponents>>(chosen, chosen_count);
  };
  step_those.template operator()<3>();
  step_those.template operator()<2>();
  step_those.template operator()<0>();
  for (uint32_t i = 0; i < count; ++i) sequences[i]->add_bits();
}

}  // namespace psplit::core
