// Bits and symbols come back as they were encoded, with and without the fast steps; broken tables and blocks
// are refused.
#include "src/core/rans.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/src/core/rans_encoder.h"
#include "tests/support/emulated_warp.h"

namespace psplit::core {
namespace {

// The probability is 192 / 256 for a 0, and the state is 4096 + 37. Steps by hand:
//   4133 = 16 * 256 + 37, 37 < 64: a 1, and the state is 16 * 64 + 37 = 1061, which no byte fills up
//   1061 = 4 * 256 + 37: a 1, 4 * 64 + 37 = 293
//   293 = 1 * 256 + 37: a 1, 64 + 37 = 101
//   101 = 0 * 256 + 101, 101 >= 64: a 0, 101 - 0 - 64 = 37
//   37: a 1
TEST(Rans, DecodesAStateByHand) {
  const Bytes bytes{192, 1, 37};
  ByteReader reader(bytes.data(), bytes.size());
  RansBits bits;
  ASSERT_EQ(bits.start(reader), Fault::kNone);
  EXPECT_EQ(reader.remaining(), 0u);
  for (const bool expected : {true, true, true, false, true}) EXPECT_EQ(bits.next(), expected);
}

TEST(Rans, BitsComeBackWithAnyProbability) {
  std::mt19937 random(1);
  for (const uint8_t prob_zero : Bytes{1, 17, 128, 250, 255}) {
    std::vector<bool> expected(1000);
    for (size_t i = 0; i < expected.size(); ++i) expected[i] = random() % 256 >= prob_zero;
    const Bytes bytes = encode_bits(expected, prob_zero);
    ByteReader reader(bytes.data(), bytes.size());
    RansBits bits;
    ASSERT_EQ(bits.start(reader), Fault::kNone);
    RansBits fast = bits;
    for (const bool bit : expected) {
      ASSERT_EQ(bits.next(), bit) << int{prob_zero};
      ASSERT_EQ(fast.next_fast(), uint32_t{bit}) << int{prob_zero};
    }
  }
}

// No encoder stores this probability. libdraco keeps the other one, 256, in a byte, so that all bits are 0.
TEST(Rans, BitsOfProbabilityZeroAreZero) {
  const Bytes bytes{0, 1, 37};
  ByteReader reader(bytes.data(), bytes.size());
  RansBits bits;
  ASSERT_EQ(bits.start(reader), Fault::kNone);
  RansBits fast = bits;
  for (int i = 0; i < 5; ++i) {
    EXPECT_FALSE(bits.next());
    EXPECT_EQ(fast.next_fast(), 0u);
  }
}

TEST(Rans, BitsNeedAState) {
  const auto start = [](const Bytes& bytes) {
    ByteReader reader(bytes.data(), bytes.size());
    return RansBits().start(reader);
  };
  EXPECT_EQ(start({128, 0}), Fault::kEntropy);                 // an empty block
  EXPECT_EQ(start({128, 1, 0x40}), Fault::kEntropy);           // one byte of two
  EXPECT_EQ(start({128, 2, 0}), Fault::kTruncated);            // a block longer than the stream
  EXPECT_EQ(start({128, 2, 0xff, 0x7f}), Fault::kNone);        // 4096 + 16383
  EXPECT_EQ(start({128, 4, 0, 0, 0, 0xc0}), Fault::kEntropy);  // bits have at most three bytes
}

// Encodes symbols with the given probabilities, and expects them back from next and from next_fast.
void expect_symbols_back(const std::vector<uint32_t>& probs, uint32_t precision_bits, uint32_t count) {
  std::mt19937 random(1);
  std::vector<uint32_t> expected(count);
  for (uint32_t& symbol : expected) do {
      symbol = static_cast<uint32_t>(random() % probs.size());
    } while (probs[symbol] == 0);
  Bytes bytes = encode_table(probs);
  append(bytes, encode_symbols(expected, probs, precision_bits));
  std::vector<uint8_t> memory(size_t{1} << 20);
  Arena arena(memory.data(), memory.size());
  ByteReader reader(bytes.data(), bytes.size());
  RansTable table;
  ASSERT_EQ(table.read(reader, precision_bits, count, arena), Fault::kNone);
  table.fill_buckets();
  EXPECT_LE(arena.mark(), RansTable::bytes(1, count) + RansTable::slot_bytes(count, bytes.size()));
  EXPECT_LE(arena.mark(), RansTable::bytes(1, count) + RansTable::slot_bytes_of_one(count, bytes.size()));
  RansSymbols slow;
  ASSERT_EQ(slow.start(reader, table), Fault::kNone);
  EXPECT_EQ(reader.remaining(), 0u);
  RansSymbols fast = slow;
  for (const uint32_t symbol : expected) {
    ASSERT_EQ(slow.next(table), symbol);
    const bool is_fast = fast.fast_steps() > 0;
    ASSERT_EQ(!is_fast            ? fast.next(table)
              : table.is_direct() ? fast.next_fast<true>(table)
                                  : fast.next_fast<false>(table),
              symbol);
  }
}

TEST(Rans, SymbolsComeBackFromDirectAndSearchedTables) {
  const std::vector<uint32_t> probs12{1000, 1, 0, 95, 3000}, probs20{1, (1u << 20) - 70'001, 0, 70'000};
  expect_symbols_back(probs12, 12, RansTable::kFew);      // direct
  expect_symbols_back(probs12, 12, RansTable::kFew - 1);  // few symbols: searched
  expect_symbols_back(probs20, 20, 5000);                 // high precision: searched
  expect_symbols_back({4096}, 12, 2000);                  // a single symbol takes no bits
}

// Lanes search the slots of each bucket; one thread walks through the slots.
TEST(Rans, LanesFillTheSameBuckets) {
  std::mt19937 random(1);
  for (const uint32_t precision_bits : {12u, 16u, 20u})
    for (const uint32_t symbol_count : {1u, 2u, 31u, 300u, 3000u}) {
      SCOPED_TRACE(std::to_string(symbol_count) + " symbols in " + std::to_string(precision_bits) + " bits");
      const uint32_t total = 1u << precision_bits;
      std::vector<uint32_t> probs(symbol_count);
      uint32_t sum = 0;
      for (uint32_t& prob : probs) sum += prob = static_cast<uint32_t>(random() % 3);
      probs[symbol_count / 2] += total - sum;
      const Bytes bytes = encode_table(probs);
      std::vector<uint8_t> memory(size_t{1} << 20);
      Arena arena(memory.data(), memory.size());
      const auto read = [&] {
        ByteReader reader(bytes.data(), bytes.size());
        RansTable table;
        EXPECT_EQ(table.read(reader, precision_bits, RansTable::kFew - 1, arena), Fault::kNone);
        return table;
      };
      RansTable serial = read();
      serial.fill_buckets();
      for (const LaneOrder order : kLaneOrders) {
        RansTable shared = read();
        run_warp([&](EmulatedLanes lanes) { shared.fill_buckets(lanes); }, order);
        for (uint32_t number = 0; number < total; ++number) {
          const RansTable::Slot a = serial.search(number), b = shared.search(number);
          ASSERT_TRUE(a.symbol() == b.symbol() && a.prob() == b.prob() && a.first() == b.first()) << number;
        }
      }
    }
}

// Different symbols take the fewest bytes if each occurs once, except one.
TEST(Rans, OneTableHasNoMoreSlotsThanItsSymbolsJustify) {
  for (const uint32_t different : {1u, 2u, 16u, 200u, 700u})
    for (const uint32_t repeats : {0u, 300u}) {
      SCOPED_TRACE(std::to_string(different) + " different, " + std::to_string(repeats) + " repeated");
      std::vector<uint32_t> symbols(repeats, 0);
      for (uint32_t symbol = 0; symbol < different; ++symbol) symbols.push_back(symbol);
      const auto count = static_cast<uint32_t>(symbols.size());
      std::vector<uint32_t> probs(different, 4096 / count);
      probs[0] = 4096 - (different - 1) * (4096 / count);
      Bytes bytes = encode_table(probs);
      append(bytes, encode_symbols(symbols, probs, 12));
      EXPECT_LE(sizeof(RansTable::Slot) * different, RansTable::slot_bytes_of_one(count, bytes.size()));
      EXPECT_LE(RansTable::slot_bytes_of_one(count, bytes.size()), RansTable::slot_bytes(count, bytes.size()));
    }
}

TEST(Rans, TablesAddUpToTheirPrecision) {
  const auto read = [](const Bytes& bytes) {
    std::vector<uint8_t> memory(size_t{1} << 20);
    Arena arena(memory.data(), memory.size());
    ByteReader reader(bytes.data(), bytes.size());
    return RansTable().read(reader, 12, 1, arena);
  };
  EXPECT_EQ(read(encode_table({4000, 96})), Fault::kNone);
  EXPECT_EQ(read(encode_table({4000, 95})), Fault::kEntropy);
  EXPECT_EQ(read(encode_table({4000, 97})), Fault::kEntropy);
  EXPECT_EQ(read({0}), Fault::kEntropy);
  EXPECT_EQ(read({2, 4096 << 2 & 0xff}), Fault::kTruncated);
  EXPECT_EQ(read({2, 0x07}), Fault::kEntropy);           // two symbols do not occur, and there are no more
  EXPECT_EQ(read({3, 0x07, 0x01, 0x40}), Fault::kNone);  // the third is the only one
}

}  // namespace
}  // namespace psplit::core
