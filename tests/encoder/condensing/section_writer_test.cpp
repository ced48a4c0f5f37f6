#include "encoder/condensing/section_writer.h"

#include <gtest/gtest.h>

#include <vector>

#include "src/core/condensed/token_steps.h"

namespace psplit {
namespace {

TEST(Token, SaysTheSymbolWithItsExtraBits) {
  std::vector<uint32_t> symbols = {~0u, ~0u - 1};
  for (uint32_t symbol = 0; symbol < 5000; ++symbol) symbols.push_back(symbol);
  for (uint32_t bit = 6; bit < 32; ++bit)
    for (const uint32_t by : {~0u, 0u, 1u}) symbols.push_back((1u << bit) + by);
  for (const uint32_t symbol : symbols) {
    const Token token = token_of(symbol);
    ASSERT_LT(token.token, core::kTokenCount);
    EXPECT_EQ(token.extra_bits, core::token_bits(token.token).bit_count);
    const uint32_t again = token.token < core::kDirectTokens
                               ? token.token
                               : (2 + token.token % 2) << token.extra_bits | token.extra;
    EXPECT_EQ(again, symbol);
  }
}

}  // namespace
}  // namespace psplit
