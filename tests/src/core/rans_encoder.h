// A straightforward encoder of what rans.h decodes, for tests: each function undoes one step of the decoder.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace psplit::core {

using Bytes = std::vector<uint8_t>;

inline void append(Bytes& to, const Bytes& more) { to.insert(to.end(), more.begin(), more.end()); }

inline void append_varint(Bytes& to, uint64_t value) {
  for (; value >= 0x80; value >>= 7) to.push_back(static_cast<uint8_t>(value | 0x80));
  to.push_back(static_cast<uint8_t>(value));
}

// The end of a block: a state as an offset from `base`, and in the top two bits the number of bytes that it
// takes.
inline void append_state(Bytes& block, uint32_t state, uint32_t base) {
  const uint32_t offset = state - base;
  uint32_t count = 1;
  while (count < 4 && offset >> (8 * count - 2) != 0) ++count;
  for (uint32_t i = 0; i < count; ++i) block.push_back(static_cast<uint8_t>(offset >> 8 * i));
  block.back() = static_cast<uint8_t>(block.back() | (count - 1) << 6);
}

// A symbol with `prob` of `total`; `first` is the sum of smaller symbols'. States stay below base * 256.
inline void encode_step(Bytes& block, uint32_t& state, uint32_t base, uint32_t total, uint32_t prob,
                        uint32_t first) {
  while (state >= uint64_t{base} / total * 256 * prob) {
    block.push_back(static_cast<uint8_t>(state));
    state >>= 8;
  }
  state = state / prob * total + state % prob + first;
}

// Bits that are 0 with a probability of `prob_zero` / 256, with their length, as RansBits::start reads them.
inline Bytes encode_bits(const std::vector<bool>& bits, uint8_t prob_zero) {
  constexpr uint32_t kBase = 4096;
  const uint32_t prob_one = 256 - prob_zero;
  Bytes block;
  uint32_t state = kBase;
  for (size_t i = bits.size(); i-- > 0;)
    bits[i] ? encode_step(block, state, kBase, 256, prob_one, 0)
            : encode_step(block, state, kBase, 256, prob_zero, prob_one);
  append_state(block, state, kBase);
  Bytes out{prob_zero};
  append_varint(out, block.size());
  append(out, block);
  return out;
}

// The probability of each symbol, as RansTable::read reads them.
inline Bytes encode_table(const std::vector<uint32_t>& probs) {
  Bytes out;
  append_varint(out, probs.size());
  for (const uint32_t prob : probs) {
    uint32_t extra_bytes = prob < 1u << 6 ? 0 : prob < 1u << 14 ? 1 : 2;
    out.push_back(static_cast<uint8_t>(prob << 2 | extra_bytes));
    for (uint32_t i = 0; i < extra_bytes; ++i) out.push_back(static_cast<uint8_t>(prob >> (8 * i + 6)));
  }
  return out;
}

// Symbols whose probabilities add up to 1 << precision_bits, with their length, as RansSymbols::start reads
// them.
inline Bytes encode_symbols(std::span<const uint32_t> symbols, const std::vector<uint32_t>& probs,
                            uint32_t precision_bits) {
  const uint32_t base = 4u << precision_bits;
  Bytes block;
  uint32_t state = base;
  for (size_t i = symbols.size(); i-- > 0;) {
    uint32_t first = 0;
    for (uint32_t lower = 0; lower < symbols[i]; ++lower) first += probs[lower];
    encode_step(block, state, base, 1u << precision_bits, probs[symbols[i]], first);
  }
  append_state(block, state, base);
  Bytes out;
  append_varint(out, block.size());
  append(out, block);
  return out;
}

}  // namespace psplit::core
