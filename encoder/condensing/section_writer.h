// Writes one section of a condensed stream: entropy-coded words from its front, plain bits from its back.
// Specification: "sections".
//
// J. Duda: Asymmetric numeral systems, 2013.
#pragma once

#include <cstdint>
#include <vector>

#include "src/container/bit_string.h"
#include "src/core/condensed/token_steps.h"

namespace psplit {

// The token of a symbol: the inverse of core::token_bits. Small symbols are tokens of their own. Of all others
// a token says the position of the highest bit, and the bit below it; the bits below those follow.
struct Token {
  uint32_t token = 0, extra_bits = 0, extra = 0;
};
inline Token token_of(uint32_t symbol) {
  if (symbol < core::kDirectTokens) return {symbol, 0, 0};
  const uint32_t extra_bits = core::floor_log2(symbol) - 1;
  const uint32_t token =
      core::kDirectTokens + 2 * (extra_bits - core::kFewestTokenBits) + (symbol >> extra_bits & 1);
  return {token, extra_bits, symbol - core::token_bits(token).base};
}

class SectionWriter {
 public:
  BitStringWriter& plain() { return plain_; }
  // A symbol whose frequency is not 0.
  void code(core::Share share) { coded_.push_back(share); }
  // A bit that is 1 with a probability of 1 to 4095 parts of 4096.
  void code_bit(bool bit, uint32_t probability) {
    code(bit ? core::Share{probability, 0} : core::Share{core::kSlots - probability, probability});
  }

  // Appends the section, and returns how many bytes it takes. A decoder takes the symbols in their order, so
  // they are coded from the last to the first.
  uint32_t append_to(std::vector<uint8_t>& bytes) {
    constexpr uint32_t kStart = 1u << 16;
    std::vector<uint16_t> words;
    uint64_t state = kStart;
    for (size_t i = coded_.size(); i-- > 0;) {
      const auto [frequency, first] = coded_[i];
      if (state >= uint64_t{frequency} << 20) {
        words.push_back(static_cast<uint16_t>(state));
        state >>= 16;
      }
      state = state / frequency * core::kSlots + state % frequency + first;
    }
    words.push_back(static_cast<uint16_t>(state >> 16));
    words.push_back(static_cast<uint16_t>(state));
    const size_t begin = bytes.size();
    const std::vector<uint8_t> bits = plain_.take();
    bytes.reserve(begin + 2 * words.size() + bits.size());
    for (size_t i = words.size(); i-- > 0;) {
      bytes.push_back(static_cast<uint8_t>(words[i]));
      bytes.push_back(static_cast<uint8_t>(words[i] >> 8));
    }
    bytes.insert(bytes.end(), bits.rbegin(), bits.rend());
    coded_.clear();
    return static_cast<uint32_t>(bytes.size() - begin);
  }

 private:
  BitStringWriter plain_;
  std::vector<core::Share> coded_;
};

}  // namespace psplit
