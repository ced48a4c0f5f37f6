// Tokens: symbols of any size as few symbols and plain bits. Specification: "tokens".
#pragma once

#include <cstdint>

#include "src/core/platform.h"

namespace psplit {

inline constexpr uint32_t kTokens = 116, kDirectTokens = 64;

// Small symbols are tokens of their own. Of all others a token says the position of the highest bit, and the
// bit below it; the bits below those follow.
struct Token {
  uint32_t token = 0, extra_bits = 0, extra = 0;
};
constexpr uint32_t extra_bits_of(uint32_t token) {
  return token < kDirectTokens ? 0 : (token - kDirectTokens) / 2 + 5;
}
inline Token token_of(uint32_t symbol) {
  if (symbol < kDirectTokens) return {symbol, 0, 0};
  const uint32_t extra_bits = core::floor_log2(symbol) - 1;
  const uint32_t token = kDirectTokens + 2 * (extra_bits - 5) + (symbol >> extra_bits & 1);
  return {token, extra_bits, symbol & ((1u << extra_bits) - 1)};
}

}  // namespace psplit
