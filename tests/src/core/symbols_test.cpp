// Both symbol codings, raw and tagged: values come back in place, alone and in step, and the reader ends after
// them.
#include "src/core/symbols.h"

#include <gtest/gtest.h>

#include "src/core/components.h"
#include "tests/src/core/rans_encoder.h"

namespace psplit::core {
namespace {

// Equal probabilities for symbols below 2^bits, in a table of 12 bits.
std::vector<uint32_t> equal_probs(uint32_t bits) { return std::vector<uint32_t>(1u << bits, 4096u >> bits); }

// Values below 16.
Bytes raw(const std::vector<uint32_t>& values) {
  Bytes out{1, 4};
  append(out, encode_table(equal_probs(4)));
  append(out, encode_symbols(values, equal_probs(4), 12));
  return out;
}

// Groups of `components` values, each with a tag below 32.
Bytes tagged(const std::vector<uint32_t>& values, const std::vector<uint32_t>& tags, uint32_t components) {
  Bytes out{0};
  append(out, encode_table(equal_probs(5)));
  append(out, encode_symbols(tags, equal_probs(5), 12));
  std::vector<bool> bits;
  for (size_t i = 0; i < values.size(); ++i)
    for (uint32_t k = 0; k < tags[i / components]; ++k) bits.push_back((values[i] >> k & 1) != 0);
  for (size_t i = 0; i < bits.size(); ++i) {
    if (i % 8 == 0) out.push_back(0);
    out.back() = static_cast<uint8_t>(out.back() | bits[i] << i % 8);
  }
  return out;
}

std::vector<uint32_t> values_below_16(size_t count) {
  std::vector<uint32_t> values(count);
  for (size_t i = 0; i < count; ++i) values[i] = static_cast<uint32_t>(i * i % 13);
  return values;
}

// Decodes one sequence; the stream has one more byte after it.
struct Decoded {
  Fault fault = Fault::kNone;
  std::vector<uint32_t> values;
  bool is_tagged = false;
};
Decoded decode(Bytes bytes, uint32_t group_count, uint32_t components) {
  bytes.push_back(0);
  std::vector<uint8_t> memory(size_t{1} << 20);
  Arena arena(memory.data(), memory.size());
  ByteReader reader(bytes.data(), bytes.size());
  Decoded out;
  out.values.resize(size_t{group_count} * components);
  SymbolSequence sequence;
  out.fault = sequence.start(reader, group_count, components, arena, {out.values.data(), out.values.size()});
  out.is_tagged = sequence.is_tagged();
  if (out.fault != Fault::kNone) return out;
  SymbolSequence* const one = &sequence;
  step_symbols<1>(&one, 1);
  out.fault = sequence.finish(SerialLanes(), reader);
  EXPECT_EQ(reader.remaining(), out.fault == Fault::kNone ? 1u : 0u);
  return out;
}

TEST(Symbols, RawValuesAreOneSymbolEach) {
  for (const uint32_t count : {1u, 999u, 6000u}) {
    const Decoded decoded = decode(raw(values_below_16(count)), count, 1);
    ASSERT_EQ(decoded.fault, Fault::kNone);
    EXPECT_FALSE(decoded.is_tagged);
    EXPECT_EQ(decoded.values, values_below_16(count));
  }
}

TEST(Symbols, ATagIsTheNumberOfBitsOfEachValueInItsGroup) {
  const std::vector<uint32_t> values{5, 0, 7, 0, 0, 0, 1u << 30, 12345, 1}, tags{3, 0, 31};
  const Decoded decoded = decode(tagged(values, tags, 3), 3, 3);
  ASSERT_EQ(decoded.fault, Fault::kNone);
  EXPECT_TRUE(decoded.is_tagged);
  EXPECT_EQ(decoded.values, values);
}

TEST(Symbols, TheStreamHasNothingForNoGroups) { EXPECT_EQ(decode({}, 0, 3).fault, Fault::kNone); }

TEST(Symbols, SequencesInStepDecodeAsEachAlone) {
  constexpr size_t kCounts[] = {2000, 300, 1500, 1, 700};
  std::vector<uint8_t> memory(size_t{1} << 20);
  Arena arena(memory.data(), memory.size());
  Bytes bytes;
  for (const size_t count : kCounts) append(bytes, raw(values_below_16(count)));
  ByteReader reader(bytes.data(), bytes.size());
  SymbolSequence sequences[std::size(kCounts)];
  SymbolSequence* pointers[std::size(kCounts)];
  std::vector<std::vector<uint32_t>> out;
  for (size_t i = 0; i < std::size(kCounts); ++i) {
    out.emplace_back(kCounts[i]);
    pointers[i] = &sequences[i];
    ASSERT_EQ(
        sequences[i].start(reader, static_cast<uint32_t>(kCounts[i]), 1, arena, {out[i].data(), kCounts[i]}),
        Fault::kNone);
  }
  step_symbols<kInStep>(pointers, std::size(kCounts));
  for (size_t i = 0; i < std::size(kCounts); ++i) {
    ASSERT_EQ(sequences[i].finish(SerialLanes(), reader), Fault::kNone);
    EXPECT_EQ(out[i], values_below_16(kCounts[i]));
  }
}

TEST(Symbols, RefusesCodingsThatDoNotExist) {
  Bytes bytes = raw({1, 2, 3});
  bytes[0] = 2;
  EXPECT_EQ(decode(bytes, 3, 1).fault, Fault::kMethod);
  bytes[0] = 1;
  for (const uint8_t bits : Bytes{0, 19}) {
    bytes[1] = bits;
    EXPECT_EQ(decode(bytes, 3, 1).fault, Fault::kEntropy);
  }
}

TEST(Symbols, TaggedValuesMayNotEndEarly) {
  Bytes bytes = tagged({255, 255}, {20, 20}, 1);
  bytes.resize(bytes.size() - 2);
  EXPECT_EQ(decode(bytes, 2, 1).fault, Fault::kTruncated);
}

TEST(Symbols, SignsAlternate) {
  const int32_t expected[] = {0, -1, 1, -2, 2, -3};
  for (uint32_t symbol = 0; symbol < std::size(expected); ++symbol)
    EXPECT_EQ(static_cast<int32_t>(signed_of_symbol(symbol)), expected[symbol]);
}

}  // namespace
}  // namespace psplit::core
