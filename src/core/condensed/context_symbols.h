// Edgebreaker's symbols of a condensed stream. The probabilities of a symbol depend on its context: on the last
// few symbols, or on the last symbol and the valence of the vertex that a C would close.
#pragma once

#include "src/core/condensed/section.h"
#include "src/core/edgebreaker_symbols.h"

namespace psplit::core {

// Decodes a symbol. Returns its place in the order C, S, L, R, E, and sets its code, which is invalid if the
// context is never used.
PSPLIT_HD PSPLIT_INLINE uint32_t next_symbol(SectionReader& section, const SymbolContext& context,
                                             uint32_t& clers) {
  const uint32_t slot = section.slot();
  // A processor cannot predict which symbol comes. This compiles to additions of carries.
  uint32_t symbol = 0;
  PSPLIT_UNROLL
  for (uint32_t s = 1; s < SymbolContext::kCount; ++s) symbol += slot >= context.shares[s].first ? 1 : 0;
  const Share share = context.shares[symbol];
  section.leave(share.frequency, slot - share.first);
  clers = context.codes[symbol];
  return symbol;
}

// Decodes all symbols in contexts of the last few, each to a byte with its code.
class ContextSymbolSteps {
 public:
  ContextSymbolSteps() = default;
  // `out` has room for at least one symbol. The first one is always E, and is not coded.
  PSPLIT_HD ContextSymbolSteps(const SectionReader& section, const CondensedModels& models, View<uint8_t> out)
      : section_(section),
        contexts_(models.contexts.data()),
        context_(models.first_context),
        at_(out.data()),
        end_(out.data() + out.size()) {
    *at_++ = kE;
  }

  PSPLIT_HD uint32_t steps_left() const { return static_cast<uint32_t>(end_ - at_); }
  PSPLIT_HD PSPLIT_INLINE void step() {
    const SymbolContext& context = contexts_[context_];
    uint32_t clers;
    context_ = context.next + next_symbol(section_, context, clers);
    if constexpr (PSPLIT_MOVES_ROWS)
      put(clers);
    else
      *at_++ = static_cast<uint8_t>(clers);
  }
  // The section after the symbols, once all steps were taken.
  PSPLIT_HD const SectionReader& section() const { return section_; }

 private:
  // Stores four symbols at once. The array is aligned.
  PSPLIT_HD PSPLIT_INLINE void put(uint32_t clers) {
    last_ = last_ >> 8 | clers << 24;
    const auto rest = static_cast<uint32_t>(reinterpret_cast<uintptr_t>(++at_) & 3);
    if (rest == 0)
      *reinterpret_cast<uint32_t*>(at_ - 4) = last_;
    else if (at_ == end_)
      for (uint32_t k = 0; k < rest; ++k)
        at_[-1 - static_cast<int>(k)] = static_cast<uint8_t>(last_ >> (24 - 8 * k));
  }

  SectionReader section_;
  const SymbolContext* contexts_ = nullptr;
  uint32_t context_ = 0;
  uint32_t last_ = uint32_t{kE} << 24;  // the last symbols, the last one highest
  uint8_t* at_ = nullptr;
  uint8_t* end_ = nullptr;
};

// Notes the first or the last corner of each vertex in the order of decoding. add_faces calls it.
template <typename Index, bool kLast>
class CornerNotes {
 public:
  PSPLIT_HD explicit CornerNotes(View<Index> corners) : corners_(corners) {}
  PSPLIT_HD void brought(uint32_t vertex, uint32_t corner) {
    if constexpr (!kLast) corners_[vertex] = static_cast<Index>(corner);
  }
  PSPLIT_HD void added(uint32_t symbol, uint32_t v0, uint32_t v1, uint32_t v2) {
    if constexpr (!kLast) return;
    if constexpr (PSPLIT_MOVES_ROWS) {
      // The next face has the vertices at corners 1 and 2 as well, unless it is an E. S merges one of them.
      if (symbol == kE) finish();
      v1_ = v1, v2_ = v2;
    } else {
      corners_[v1] = static_cast<Index>(corner_ + 1);
      corners_[v2] = static_cast<Index>(corner_ + 2);
    }
    corners_[v0] = static_cast<Index>(corner_);
    corner_ += 4;
  }
  // Called after the last face.
  PSPLIT_HD void finish() {
    if (!kLast || !PSPLIT_MOVES_ROWS || corner_ == 0) return;
    corners_[v1_] = static_cast<Index>(corner_ - 3);
    corners_[v2_] = static_cast<Index>(corner_ - 2);
  }

 private:
  View<Index> corners_;
  uint32_t corner_ = 0;
  uint32_t v1_ = 0, v2_ = 0;  // of the last face, on a device
};

// Symbols that are decoded to bytes.
template <typename Index, bool kLast>
class DecodedSymbols : public CornerNotes<Index, kLast> {
 public:
  PSPLIT_HD DecodedSymbols(View<const uint8_t> symbols, View<Index> corners)
      : CornerNotes<Index, kLast>(corners), at_(symbols.data()) {}
  PSPLIT_HD uint32_t next(uint32_t) { return *at_++; }
  PSPLIT_HD void merged(uint32_t, uint32_t) {}

 private:
  const uint8_t* at_;
};

// Symbols in contexts of valences, which are known only while faces are added. They are read from a copy of
// `section`, which stays in registers; `finish` copies it back.
template <typename Index, bool kLast>
class ValenceContextSymbols : public CornerNotes<Index, kLast> {
 public:
  PSPLIT_HD ValenceContextSymbols(const Valences<Index>& valences, const CondensedModels& models,
                                  SectionReader& section, View<Index> corners)
      : CornerNotes<Index, kLast>(corners),
        valences_(valences),
        contexts_(models.contexts.data()),
        section_(section),
        out_(&section) {}

  PSPLIT_HD uint32_t next(uint32_t to) {
    if (to == kNone<Index>) return kE;
    const uint32_t context = SymbolContext::kCount * valences_.class_of(to) + last_;
    uint32_t clers;
    last_ = next_symbol(section_, contexts_[context], clers);
    return clers;
  }
  PSPLIT_HD void added(uint32_t symbol, uint32_t v0, uint32_t v1, uint32_t v2) {
    CornerNotes<Index, kLast>::added(symbol, v0, v1, v2);
    valences_.added(symbol, v0, v1, v2);
  }
  PSPLIT_HD void merged(uint32_t p, uint32_t n) { valences_.merged(p, n); }
  PSPLIT_HD void finish() {
    CornerNotes<Index, kLast>::finish();
    *out_ = section_;
  }

 private:
  Valences<Index> valences_;
  const SymbolContext* contexts_;
  SectionReader section_;
  SectionReader* out_;
  uint32_t last_ = SymbolContext::kCount - 1;  // E
};

}  // namespace psplit::core
