// The values of an attribute of a condensed stream: symbols as tokens. A small symbol is a token of its own. A
// larger one is a token for its two highest bits, and plain bits.
#pragma once

#include "src/core/condensed/section.h"
#include "src/core/in_step.h"

namespace psplit::core {

// A symbol is `base` plus the number in `bit_count` plain bits.
struct TokenBits {
  uint32_t base, bit_count;
};
PSPLIT_HD constexpr TokenBits token_bits(uint32_t token) {
  constexpr uint32_t kDirect = 64, kFewestBits = 5;
  if (token < kDirect) return {token, 0};
  const uint32_t bit_count = (token - kDirect) / 2 + kFewestBits;
  return {(2 + token % 2) << bit_count, bit_count};
}

struct TokenBitsTable {
  constexpr TokenBitsTable() {
    for (uint32_t token = 0; token < 256; ++token)
      of[token] = token < kTokenCount ? token_bits(token) : TokenBits{};
  }
  TokenBits of[256] = {};
};
inline constexpr TokenBitsTable kTokenBits;

PSPLIT_HD inline TokenBits bits_of_token(uint32_t token) {
#if defined(__CUDA_ARCH__)
  return token_bits(token);
#else
  return kTokenBits.of[token];
#endif
}

// The symbols of one attribute, which are decoded later. Several sequences may be decoded in step.
class TokenSequence {
 public:
  // `table_of` has a number of one of `tables` for each value: those tables exist. `out` has room for the
  // symbols of all values.
  PSPLIT_HD void start(const SectionReader& section, const CondensedModels& models, const AttributeModel& model,
                       uint32_t components, View<const uint8_t> table_of, View<uint32_t> out) {
    section_ = section;
    components_ = components;
    for (uint32_t i = 0; i < AttributeModel::kTables; ++i)
      tables_[i] = model.tables[i] == AttributeModel::kNoTable
                       ? nullptr
                       : &models.token_tables[size_t{model.tables[i]} * kSlots];
    table_of_ = table_of.data();
    end_ = table_of_ + table_of.size();
    out_ = out.data();
  }
  PSPLIT_HD uint32_t components() const { return components_; }
  // Behind the tokens, when all steps were taken.
  PSPLIT_HD SectionReader& section() { return section_; }
  PSPLIT_HD bool running() const { return table_of_ != end_; }

 protected:
  SectionReader section_;
  uint32_t components_ = 0;
  const TokenEntry* tables_[AttributeModel::kTables] = {};
  const uint8_t* table_of_ = nullptr;
  const uint8_t* end_ = nullptr;
  uint32_t* out_ = nullptr;
};

// Decodes one value a step. kComponents is 0 if their number is known only at run time.
template <uint32_t kComponents>
class TokenSteps : public TokenSequence {
 public:
  TokenSteps() = default;
  PSPLIT_HD explicit TokenSteps(const TokenSequence& sequence) : TokenSequence(sequence) {}

  PSPLIT_HD PSPLIT_INLINE void step() {
    const TokenEntry* const table = tables_[*table_of_++];
    if constexpr (kComponents == 0) {
      for (uint32_t k = 0; k < components_; ++k) {
        const TokenBits bits = bits_of_token(section_.next_token(table));
        *out_++ = bits.base + section_.read(static_cast<int>(bits.bit_count));
      }
    } else {
      step_together(table);
    }
  }

 private:
  // The bits of all components at once, if one load has them.
  PSPLIT_HD PSPLIT_INLINE void step_together(const TokenEntry* table) {
    constexpr uint32_t kMostBits = 56;
    TokenBits bits[kComponents];
    uint32_t together = 0;
    for (TokenBits& of : bits) {
      of = bits_of_token(section_.next_token(table));
      together += of.bit_count;
    }
    if (PSPLIT_LIKELY(together <= kMostBits)) {
      uint64_t ahead = section_.peek(kMostBits);
      section_.take(static_cast<int>(together));
      for (const TokenBits& of : bits) {
        *out_++ = of.base + static_cast<uint32_t>(ahead & ((uint64_t{1} << of.bit_count) - 1));
        ahead >>= of.bit_count;
      }
    } else {
      for (const TokenBits& of : bits) *out_++ = of.base + section_.read(static_cast<int>(of.bit_count));
    }
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
    step_all<kRuns, TokenSteps<kComponents>>(chosen, chosen_count);
  };
  step_those.template operator()<3>();
  step_those.template operator()<2>();
  step_those.template operator()<0>();
}

}  // namespace psplit::core
