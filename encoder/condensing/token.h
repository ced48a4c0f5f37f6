// The token of a symbol: the inverse of core::token_bits. Specification: "tokens".
#pragma once

#include "src/core/condensed/token_steps.h"

namespace psplit {

// Small symbols are tokens of their own. Of all others a token says the position of the highest bit, and the
// bit below it; the bits below those follow.
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

}  // namespace psplit
