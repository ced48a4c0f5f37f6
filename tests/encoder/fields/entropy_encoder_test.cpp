// The core decodes what the encoders write. Streams show that the bytes are libdraco's (draco_fields_test.cpp).
#include "encoder/fields/entropy_encoder.h"

#include <gtest/gtest.h>

#include <random>

#include "src/container/bit_string.h"
#include "src/core/symbols.h"

namespace psplit {
namespace {

using Bytes = std::vector<uint8_t>;

std::vector<uint32_t> decode(const Bytes& bytes, size_t count, uint32_t components) {
  std::vector<uint32_t> out(count);
  std::vector<uint8_t> memory(core::SymbolSequence::bytes(1, count) +
                              core::RansTable::slot_bytes(~0ull, bytes.size()));
  core::Arena arena(memory.data(), memory.size());
  core::ByteReader reader(bytes.data(), bytes.size());
  core::SymbolSequence sequence;
  const auto groups = static_cast<uint32_t>(count / components);
  EXPECT_EQ(sequence.start(reader, groups, components, arena, {out.data(), out.size()}), core::Fault::kNone);
  EXPECT_EQ(sequence.finish(core::SerialLanes(), reader), core::Fault::kNone);
  EXPECT_EQ(reader.remaining(), 0u);
  return out;
}

// Symbols with about `bits` bits, small ones more often.
std::vector<uint32_t> random_symbols(size_t count, int bits, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<uint32_t> symbols(count);
  for (uint32_t& symbol : symbols) symbol = static_cast<uint32_t>(random()) >> (32 - bits) >> random() % 8;
  return symbols;
}

TEST(EntropyEncoder, SymbolsComeBackAtEveryLevel) {
  for (int level = 0; level <= kLevelBeforeLevels; ++level)
    for (const int bits : {1, 3, 8, 12, 17, 18, 19, 27, 31})
      for (const size_t count : {1u, 2u, 30u, 600u, 20000u})
        for (const uint32_t components : {1u, 2u, 3u, 5u}) {
          const std::vector<uint32_t> symbols =
              random_symbols(count * components, bits, static_cast<uint32_t>(count));
          Bytes bytes;
          encode_symbols(symbols, components, level, bytes);
          ASSERT_EQ(decode(bytes, symbols.size(), components), symbols) << bits << " bits, level " << level;
        }
}

TEST(EntropyEncoder, EverySymbolOfTheAlphabetOccurs) {
  for (const uint32_t count : {2u, 64u, 65u, 4000u, 200000u, 1u << 18}) {
    std::vector<uint32_t> symbols(count);
    for (uint32_t i = 0; i < count; ++i) symbols[i] = count - 1 - i;
    Bytes bytes;
    encode_symbols(symbols, 1, 0, bytes);
    EXPECT_EQ(decode(bytes, count, 1), symbols);
  }
}

TEST(EntropyEncoder, NothingIsWrittenForNoSymbols) {
  Bytes bytes;
  encode_symbols({}, 3, 5, bytes);
  EXPECT_TRUE(bytes.empty());
}

TEST(EntropyEncoder, SymbolsOf32BitsAreTagged) {
  const std::vector<uint32_t> symbols = {1, 2, 1u << 31, 0xffffffffu};
  Bytes bytes;
  encode_symbols(symbols, 1, 5, bytes);
  EXPECT_EQ(decode(bytes, symbols.size(), 1), symbols);
}

// 5 different symbols take 3 bits; levels below 4 take two bits less, levels 4 and 5 one, levels 8 and 9 one
// more and level 10 two more. Symbol 4 takes 3 bits.
TEST(EntropyEncoder, LevelsFollowFromTheBits) {
  const std::vector<uint32_t> symbols = {0, 1, 2, 3, 4, 4, 4};
  EXPECT_EQ(possible_symbol_levels(symbols, 1), 0b1111u);
  EXPECT_EQ(possible_symbol_levels(symbols, 2), 0b110000u);
  EXPECT_EQ(possible_symbol_levels(symbols, 3), 0b100011000000u);
  EXPECT_EQ(possible_symbol_levels(symbols, 4), 0b1100000000u);
  EXPECT_EQ(possible_symbol_levels(symbols, 5), 0b10000000000u);
  EXPECT_EQ(possible_symbol_levels(symbols, 6), 0u);
}

TEST(EntropyEncoder, FlagsComeBack) {
  std::mt19937 random(3);
  for (const size_t count : {0u, 1u, 7u, 100u, 5000u})
    for (const uint32_t often : {0u, 1u, 50u, 128u, 255u, 256u}) {
      Bytes flags(count), bytes;
      for (uint8_t& flag : flags) flag = random() % 256 < often;
      encode_flags(flags, bytes);
      core::ByteReader reader(bytes.data(), bytes.size());
      core::RansBits bits;
      ASSERT_EQ(bits.start(reader), core::Fault::kNone);
      EXPECT_EQ(reader.remaining(), 0u);
      for (const uint8_t flag : flags) ASSERT_EQ(bits.next(), flag != 0);
    }
}

TEST(EntropyEncoder, BitsComeBack) {
  BitStringWriter bits;
  for (uint32_t count = 0; count <= 32; ++count) bits.bits(0xa5a5a5a5u, count);
  const Bytes bytes = bits.take();
  EXPECT_EQ(bytes.size(), 66u);  // 0 + 1 + ... + 32 bits
  core::BitReader reader(bytes.data(), bytes.size());
  for (int count = 0; count <= 32; ++count)
    EXPECT_EQ(reader.read(count), static_cast<uint32_t>((uint64_t{1} << count) - 1) & 0xa5a5a5a5u);
}

}  // namespace
}  // namespace psplit
