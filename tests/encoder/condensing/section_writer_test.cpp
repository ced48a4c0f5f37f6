// What SectionWriter writes, core::SectionReader reads.
#include "encoder/condensing/section_writer.h"

#include <gtest/gtest.h>

#include <random>

#include "src/core/condensed/section.h"

namespace psplit {
namespace {

struct Step {
  enum { kSymbol, kBit, kPlain } kind;
  uint32_t value, parameter;
};

core::TokenTable table_of(std::span<const uint16_t> frequencies) {
  core::TokenTable table;
  uint32_t slot = 0;
  for (uint32_t symbol = 0; symbol < frequencies.size(); ++symbol) {
    table.shares[symbol] = {frequencies[symbol], slot};
    for (uint32_t i = 0; i < frequencies[symbol]; ++i) table.token_of[slot++] = static_cast<uint8_t>(symbol);
  }
  return table;
}

void expect_round_trip(std::span<const Step> steps, std::span<const uint16_t> frequencies) {
  SectionWriter writer;
  const core::TokenTable table = table_of(frequencies);
  for (const auto& [kind, value, parameter] : steps) {
    if (kind == Step::kSymbol) writer.code(table.shares[value]);
    if (kind == Step::kBit) writer.code_bit(value != 0, parameter);
    if (kind == Step::kPlain) writer.plain().bits(value, parameter);
  }
  std::vector<uint8_t> bytes;
  const uint32_t byte_count = writer.append_to(bytes);
  EXPECT_EQ(byte_count, bytes.size());
  core::SectionReader reader(bytes.data(), bytes.size());
  ASSERT_EQ(reader.start_words(0), core::Fault::kNone);
  for (const auto& [kind, value, parameter] : steps) {
    const uint32_t read = kind == Step::kSymbol ? reader.next_token(table)
                          : kind == Step::kBit  ? reader.next_bit(parameter)
                                                : reader.read(static_cast<int>(parameter));
    EXPECT_EQ(read, value);
  }
  EXPECT_TRUE(reader.is_at_end());
}

TEST(SectionWriter, ReaderReadsWhatWasWritten) {
  expect_round_trip({}, {});
  std::mt19937 random(1);
  const std::vector<std::vector<uint16_t>> tables = {
      {4096}, {0, 4096}, {1, 4095}, {4095, 1}, {1000, 0, 96, 3000}};
  for (const std::vector<uint16_t>& table : tables)
    for (const uint32_t count : {1u, 7u, 1000u}) {
      std::vector<Step> steps;
      while (steps.size() < count) {
        const auto symbol = static_cast<uint32_t>(random() % table.size());
        const auto probability = static_cast<uint32_t>(1 + random() % 4095);
        const auto bits = static_cast<uint32_t>(random() % 31);
        if (table[symbol] > 0) steps.push_back({Step::kSymbol, symbol, 0});
        steps.push_back({Step::kBit, static_cast<uint32_t>(random() % 2), probability});
        steps.push_back({Step::kPlain, static_cast<uint32_t>(random() % (uint64_t{1} << bits)), bits});
      }
      expect_round_trip(steps, table);
    }
}

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
