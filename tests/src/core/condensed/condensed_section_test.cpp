// Sections of condensed streams, and the readers of their contents, against the encoder's writer of sections.
#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

#include "encoder/condensing/section_writer.h"
#include "src/container/condensed_head.h"
#include "src/core/condensed/border_part.h"
#include "src/core/condensed/condensed_numbers.h"
#include "src/core/condensed/context_symbols.h"
#include "src/core/condensed/section.h"
#include "src/core/condensed/token_steps.h"

namespace psplit::core {
namespace {

using Bytes = std::vector<uint8_t>;

// Frequencies of `count` symbols that sum to 4096. Every third symbol does not occur.
std::vector<uint16_t> frequencies_of(uint32_t count, std::mt19937& random) {
  std::vector<uint16_t> frequencies(count);
  for (uint32_t left = kSlots; left > 0;)
    for (uint32_t s = 0; s < count && left > 0; ++s) {
      if (s % 3 == 2) continue;
      const auto more =
          static_cast<uint16_t>(std::min<uint32_t>(left, 1 + static_cast<uint32_t>(random() % 200)));
      frequencies[s] = static_cast<uint16_t>(frequencies[s] + more);
      left -= more;
    }
  return frequencies;
}

// The models of a head with these contexts and one table of tokens.
CondensedHead head_of(uint32_t coding, const std::vector<std::vector<uint16_t>>& contexts,
                      const std::vector<uint16_t>& tokens) {
  BitStringWriter out;
  NumberKind count{0}, length{5}, used{5}, frequency{4};
  out.number(count, 0);
  out.bits(0, 4);
  out.number(length, 0);
  out.bits(coding, 4);
  for (const std::vector<uint16_t>& context : contexts)
    for (const uint16_t f : context) out.number(frequency, f);
  out.number(count, 0);
  out.bits(0, 1);
  out.number(count, 0);  // one set of tables
  out.number(used, tokens.size());
  frequency = NumberKind(4);
  for (const uint16_t f : tokens) out.number(frequency, f);
  out.number(used, 0);
  out.bits(0, 1);  // no flags
  out.number(count, 0);
  std::vector<uint8_t> bytes;
  append_head_section(HeadSection::kTables, out.take(), bytes);
  Expected<CondensedHead> head = read_condensed_head(bytes);
  EXPECT_TRUE(head) << head.status().message();
  return head ? std::move(*head) : CondensedHead();
}
const std::vector<uint16_t> kOneSymbol = {4096, 0, 0, 0, 0};

TEST(Section, HasBitsFromItsBack) {
  SectionWriter writer;
  writer.plain().bits(0b101, 3);
  writer.plain().bits(0x1234, 16);
  NumberKind written{2}, read{2};
  for (const uint32_t number : {0u, 7u, 100000u, 0xffffffffu, 3u}) writer.plain().number(written, number);
  Bytes bytes;
  writer.append_to(bytes);
  SectionReader reader(bytes.data(), bytes.size());
  EXPECT_EQ(reader.read(3), 0b101u);
  EXPECT_EQ(reader.read(16), 0x1234u);
  CondensedNumbers numbers(reader);
  for (const uint32_t number : {0u, 7u, 100000u, 0xffffffffu, 3u}) EXPECT_EQ(numbers.number(read), number);
  EXPECT_FALSE(numbers.broken());
  for (int i = 0; i < 40; ++i) numbers.number(read);
  EXPECT_TRUE(numbers.broken());
}

void expect_words_and_bits(const std::vector<uint16_t>& frequencies, uint32_t count, std::mt19937& random) {
  struct Step {
    uint32_t token, bit, plain;
  };
  const CondensedHead head = head_of(0, {kOneSymbol}, frequencies);
  const auto below = [&](uint64_t bound) { return static_cast<uint32_t>(random() % bound); };
  const auto width_of = [](uint32_t step) { return step % 31; };
  SectionWriter writer;
  std::vector<Step> steps;
  uint32_t plain_bits = 0;
  for (uint32_t i = 0; i < count; ++i) {
    uint32_t token = below(frequencies.size());
    while (frequencies[token] == 0) token = below(frequencies.size());
    steps.push_back({token, below(2), below(uint64_t{1} << width_of(i))});
    writer.code(head.token_tables[0].shares[token]);
    writer.code_bit(steps[i].bit != 0, 1 + i % (kSlots - 1));
    writer.plain().bits(steps[i].plain, width_of(i));
    plain_bits += width_of(i);
  }
  Bytes bytes;
  const uint32_t byte_count = writer.append_to(bytes);
  EXPECT_EQ(byte_count, bytes.size());
  const auto read = [&](const Bytes& from) {
    SectionReader reader(from.data(), from.size());
    if (reader.start_words(0) != Fault::kNone) return false;
    bool same = true;
    for (uint32_t i = 0; i < count; ++i) {
      same &= reader.next_token(head.token_tables[0]) == steps[i].token;
      same &= reader.next_bit(1 + i % (kSlots - 1)) == steps[i].bit;
      same &= reader.read(static_cast<int>(width_of(i))) == steps[i].plain;
    }
    return same && reader.is_at_end();
  };
  EXPECT_TRUE(read(bytes));
  Bytes longer = bytes;
  longer.insert(longer.begin(), 0);
  EXPECT_FALSE(read(longer));
  for (size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 50)
    EXPECT_FALSE(read(Bytes(bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(length)))) << length;
  if (plain_bits % 8 != 0) {  // the last byte has unused bits
    Bytes dirty = bytes;
    dirty[bytes.size() - (plain_bits + 7) / 8] |= 0x80;
    EXPECT_FALSE(read(dirty));
  }
}

TEST(Section, HoldsItsWordsAndItsBitsAndNothingElse) {
  std::mt19937 random(1);
  const std::vector<uint16_t> tables[] = {frequencies_of(60, random), {4096}, {0, 4096}, {1, 4095}, {4095, 1},
                                          {1000, 0, 96, 3000}};
  for (const std::vector<uint16_t>& frequencies : tables)
    for (const uint32_t count : {0u, 1u, 2u, 50u, 1000u}) expect_words_and_bits(frequencies, count, random);
}

TEST(Tokens, CoverAllSymbols) {
  uint64_t next = 0;
  for (uint32_t token = 0; token < kTokenCount; ++token) {
    EXPECT_EQ(token_bits(token).base, next) << token;
    next += uint64_t{1} << token_bits(token).bit_count;
    EXPECT_EQ(bits_of_token(token).base, token_bits(token).base);
    EXPECT_EQ(bits_of_token(token).bit_count, token_bits(token).bit_count);
  }
  EXPECT_EQ(next, uint64_t{1} << 32);
}

// Sequences of all numbers of components are decoded in step, with few and with many bits together.
TEST(Tokens, DecodeToTheirSymbolsInStep) {
  std::mt19937 random(2);
  const std::vector<uint16_t> frequencies = frequencies_of(kTokenCount, random);
  const CondensedHead head = head_of(0, {kOneSymbol}, frequencies);
  constexpr uint32_t kSequences = 9;
  TokenSequence sequences[kSequences];
  std::vector<Bytes> sections(kSequences);
  std::vector<std::vector<uint32_t>> expected(kSequences), decoded(kSequences);
  const std::vector<uint8_t> table_of(1000, 0);
  TokenSequence* runs[kSequences];
  for (uint32_t n = 0; n < kSequences; ++n) {
    const uint32_t components = 1 + n % 5, count = 100 * n;
    SectionWriter writer;
    for (uint32_t i = 0; i < count * components; ++i) {
      uint32_t token = static_cast<uint32_t>(random() % (n < 5 ? 80 : kTokenCount));
      while (frequencies[token] == 0) --token;
      const TokenBits bits = token_bits(token);
      const auto low = static_cast<uint32_t>(random() & ((uint64_t{1} << bits.bit_count) - 1));
      writer.code(head.token_tables[0].shares[token]);
      writer.plain().bits(low, bits.bit_count);
      expected[n].push_back(bits.base + low);
    }
    writer.append_to(sections[n]);
    decoded[n].resize(expected[n].size());
    SectionReader section(sections[n].data(), sections[n].size());
    ASSERT_EQ(section.start_words(0), Fault::kNone);
    sequences[n].start(section, head.models(), head.table_sets[0], components, {table_of.data(), count},
                       {decoded[n].data(), decoded[n].size()});
    runs[n] = &sequences[n];
  }
  step_tokens<kInStep>(runs, kSequences);
  for (uint32_t n = 0; n < kSequences; ++n) {
    EXPECT_EQ(decoded[n], expected[n]) << n;
    EXPECT_TRUE(sequences[n].section().is_at_end()) << n;
  }
}

// The first value of a border part has a table of its own; others are differences.
TEST(BorderPart, DecodesAlone) {
  std::vector<uint16_t> frequencies(kTokenCount, 35);
  frequencies[0] = static_cast<uint16_t>(kSlots - 35 * (kTokenCount - 1));
  const CondensedHead head = head_of(0, {kOneSymbol}, frequencies);
  constexpr uint32_t kComponents = 3, kCount = 200;
  std::mt19937 random(3);
  SectionWriter writer;
  std::vector<int32_t> values;
  writer.plain().bits(0b1011, 4);  // numbers before the part
  for (uint32_t i = 0; i < kCount * kComponents; ++i) {
    values.push_back(static_cast<int32_t>(random() % (i % 7 == 0 ? 0xffffffffu : 1000)));
    const int32_t before = i < kComponents ? 0 : values[i - kComponents];
    const auto symbol = static_cast<uint32_t>(fold(wrapping_sub(values[i], before)));
    uint32_t token = kTokenCount - 1;
    while (token_bits(token).base > symbol) --token;
    writer.code(head.token_tables[0].shares[token]);
    writer.plain().bits(symbol - token_bits(token).base, token_bits(token).bit_count);
  }
  Bytes bytes = {9, 9, 9, 9, 9, 9};  // another section
  const size_t first_section = bytes.size();
  writer.append_to(bytes);
  CondensedStream stream;
  stream.bytes = {bytes.data(), bytes.size()};
  stream.models = head.models();
  stream.models.has_borders = true;
  stream.models.border_tables[0] = stream.models.border_tables[1] = 0;
  stream.first_section = first_section;
  stream.numbers_end = 4;
  stream.border_count = kCount;
  stream.border_components = kComponents;
  std::vector<int32_t> decoded(values.size());
  std::vector<uint8_t> is_own(kCount);
  const View<uint32_t> symbols(reinterpret_cast<uint32_t*>(decoded.data()), decoded.size());
  WalkValues walk{{decoded.data(), decoded.size()}, {is_own.data(), is_own.size()}};
  TokenSequence tokens;
  ASSERT_EQ(start_border_part(stream, walk.is_own, symbols, tokens), Fault::kNone);
  TokenSequence* const one = &tokens;
  step_tokens<1>(&one, 1);
  EXPECT_TRUE(tokens.section().is_at_end());
  StitchRow row;  // without runs
  ASSERT_EQ(place_own_values(row, stream, walk), Fault::kNone);
  EXPECT_EQ(walk.length, kCount);
  EXPECT_EQ(decoded, values);
  EXPECT_EQ(is_own, std::vector<uint8_t>(kCount, 1));
  stream.models.border_tables[1] = kNoTable;
  EXPECT_EQ(start_border_part(stream, walk.is_own, symbols, tokens), Fault::kEntropy);
}

TEST(ContextSymbols, DependOnTheLastSymbols) {
  constexpr std::array<uint32_t, 5> kCodes = {kC, kS, kL, kR, kE};
  for (uint32_t k = 0, count = 1; k <= 5; ++k, count *= SymbolContext::kCount) {
    std::mt19937 random(k);
    std::vector<std::vector<uint16_t>> contexts;
    for (uint32_t c = 0; c < count; ++c) contexts.push_back(frequencies_of(5, random));
    const CondensedHead head = head_of(k, contexts, {});
    SectionWriter writer;
    std::vector<uint8_t> expected = {kE}, decoded(3000);
    uint32_t context = count - 1;
    while (expected.size() < decoded.size()) {
      uint32_t symbol = static_cast<uint32_t>(random() % 5);
      if (symbol == 2) symbol = 0;
      writer.code(head.contexts[context].shares[symbol]);
      expected.push_back(static_cast<uint8_t>(kCodes[symbol]));
      context = (5 * context + symbol) % count;
    }
    Bytes bytes;
    writer.append_to(bytes);
    SectionReader section(bytes.data(), bytes.size());
    ASSERT_EQ(section.start_words(0), Fault::kNone);
    ContextSymbolSteps steps(section, head.models(), {decoded.data(), decoded.size()});
    while (steps.steps_left() > 0) steps.step();
    EXPECT_EQ(decoded, expected) << k;
    EXPECT_TRUE(steps.section().is_at_end()) << k;
  }
}

// A context without frequencies codes no symbol.
TEST(ContextSymbols, AreInvalidInAContextThatIsNeverUsed) {
  const CondensedHead head = head_of(1, {kOneSymbol, kOneSymbol, kOneSymbol, kOneSymbol, {0, 0, 0, 0, 0}}, {});
  const Bytes bytes = {1, 2, 3, 4};
  SectionReader section(bytes.data(), bytes.size());
  ASSERT_EQ(section.start_words(0), Fault::kNone);
  std::array<uint8_t, 2> decoded;
  ContextSymbolSteps steps(section, head.models(), {decoded.data(), decoded.size()});
  while (steps.steps_left() > 0) steps.step();
  EXPECT_EQ(decoded[0], kE);
  EXPECT_EQ(decoded[1], SymbolContext::kInvalid);
}

}  // namespace
}  // namespace psplit::core
