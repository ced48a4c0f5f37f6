// The head of a container with condensed streams is read, and malformed heads are refused.
#include "src/container/condensed_head.h"

#include <gtest/gtest.h>

#include <functional>

#include "src/container/bit_string.h"
#include "tests/support/expect.h"
#include "tests/support/mutants.h"

namespace psplit {
namespace {

// A head that a test may change before it is written.
struct HeadFields {
  std::vector<std::vector<uint8_t>> skeletons = {{0, 0, 7}, {}};  // after kSkeletonFront
  uint32_t level = 5, contexts = 1;
  std::vector<std::array<uint32_t, 5>> symbols = {{4096, 0, 0, 0, 0},
                                                  {0, 0, 0, 0, 0},
                                                  {1, 2, 3, 4, 4086},
                                                  {0, 0, 4096, 0, 0},
                                                  {1000, 1000, 1000, 1000, 96}};
  uint32_t reach = 1, set_count = 2;
  std::vector<uint32_t> tokens = {4000, 0, 96};
  uint32_t flag_probability = 1, seam_probability = 4095;
  uint32_t more_attributes = 0, sets_of_each = 1, seam_count = 1;
  bool has_borders = true;
};

std::vector<uint8_t> write(const HeadFields& head) {
  BitStringWriter out;
  core::NumberKind count{0}, length{5}, used{5};
  const auto table = [&](const std::vector<uint32_t>& frequencies) {
    core::NumberKind frequency{4};
    out.number(used, frequencies.size());
    for (const uint32_t f : frequencies) out.number(frequency, f);
  };
  out.number(count, head.skeletons.size() - 1);
  for (const std::vector<uint8_t>& skeleton : head.skeletons) {
    out.bits(head.level, 4);
    out.number(length, skeleton.size());
    for (const uint8_t byte : skeleton) out.bits(byte, 8);
  }
  out.bits(head.contexts, 4);
  core::NumberKind frequency{4};
  for (const std::array<uint32_t, 5>& symbols : head.symbols)
    for (const uint32_t f : symbols) out.number(frequency, f);
  out.number(count, 1 + head.more_attributes);  // two attributes, and those
  out.bits(1, 1);                               // by creation: backward, two, not mean
  out.bits(0b011, 3);
  out.bits(head.reach, 2);
  out.number(count, head.set_count - 1);
  table(head.tokens);
  table({});
  table({4096});
  for (uint32_t set = 1; set < head.set_count; ++set) {
    table({});
    table({0, 4096});
    table({});
  }
  out.bits(0, 1);
  out.bits(0, 1);
  out.number(count, 0);
  table({4096});
  table(head.tokens);
  out.bits(1, 1);
  for (int i = 0; i < 6; ++i) out.bits(head.flag_probability, 12);
  for (uint32_t i = 0; i < head.more_attributes; ++i) {
    out.bits(0, 1);
    out.number(count, head.sets_of_each - 1);
    for (uint32_t n = 0; n < 2 * head.sets_of_each; ++n) table({});
    out.bits(0, 1);
  }
  out.number(count, head.seam_count);
  for (uint32_t i = 0; i < head.seam_count; ++i) {
    out.bits(7, 12);
    out.bits(head.seam_probability, 12);
  }
  std::vector<uint8_t> bytes;
  append_head_section(HeadSection::kTables, out.take(), bytes);
  if (!head.has_borders) return bytes;
  used = core::NumberKind{5};
  table({4096});
  table({});
  append_head_section(HeadSection::kBorders, out.take(), bytes);
  return bytes;
}

std::string error_of(const HeadFields& head) {
  const Expected<CondensedHead> read = read_condensed_head(write(head));
  return read ? "" : read.status().message();
}

TEST(CondensedHead, IsReadAsItWasWritten) {
  const HeadFields fields;
  const auto head = must(read_condensed_head(write(fields)));
  EXPECT_EQ(head.skeletons[0], (std::vector<uint8_t>{'D', 'R', 'A', 'C', 'O', 2, 2, 1, 1, 0, 0, 7}));
  EXPECT_EQ(head.skeletons[1], std::vector<uint8_t>(kSkeletonFront.begin(), kSkeletonFront.end()));
  EXPECT_EQ(head.levels, (std::vector<uint8_t>{5, 5}));
  const core::CondensedModels models = head.models();
  EXPECT_FALSE(models.has_valence_contexts);
  EXPECT_EQ(models.first_context, 4u);
  ASSERT_EQ(models.contexts.size(), 5u);
  EXPECT_EQ(models.contexts[4].next, 0u);
  ASSERT_EQ(models.attributes.size(), 2u);
  const core::AttributeModel created = models.attributes[0], traversed = models.attributes[1];
  EXPECT_TRUE(created.by_creation && created.backward && created.two && !created.mean && created.reach == 1);
  EXPECT_FALSE(traversed.by_creation);
  EXPECT_TRUE(traversed.has_flags && traversed.flips == 1);
  EXPECT_EQ(created.first_set, 0u);
  EXPECT_EQ(created.set_count, 2u);
  EXPECT_EQ(traversed.first_set, 2u);
  EXPECT_EQ(traversed.set_count, 1u);
  ASSERT_EQ(models.table_sets.size(), 3u);
  EXPECT_EQ(models.table_sets[0].tables[1], core::kNoTable);
  EXPECT_EQ(models.table_sets[1].tables[0], core::kNoTable);
  EXPECT_EQ(models.table_sets[2].tables[2], core::kNoTable);
  const core::TokenTable &first = models.token_tables[models.table_sets[0].tables[0]],
                         &second = models.token_tables[models.table_sets[1].tables[1]];
  EXPECT_EQ(first.token_of[3999], 0u);
  EXPECT_EQ(first.token_of[4000], 2u);
  EXPECT_EQ(first.token_of[4095], 2u);
  EXPECT_EQ(first.shares[2].frequency, 96u);
  EXPECT_EQ(first.shares[2].first, 4000u);
  EXPECT_EQ(second.token_of[0], 1u);
  EXPECT_TRUE(models.has_borders);
  EXPECT_NE(models.border_tables[0], core::kNoTable);
  EXPECT_EQ(models.border_tables[1], core::kNoTable);
  ASSERT_EQ(models.seams.size(), 1u);
  EXPECT_EQ(models.seams[0].after[1], 4095u);
}

TEST(CondensedHead, SaysWhatIsWrong) {
  const auto with = [](const std::function<void(HeadFields&)>& change) {
    HeadFields head;
    change(head);
    return error_of(head);
  };
  EXPECT_EQ(with([](HeadFields&) {}), "");
  EXPECT_EQ(with([](HeadFields& head) { head.skeletons.resize(256); }), "head: more than 255 skeletons");
  EXPECT_EQ(with([](HeadFields& head) { head.skeletons[1].resize(4097); }),
            "head: a skeleton of more than 4096 bytes");
  EXPECT_EQ(with([](HeadFields& head) { head.level = 12; }), "head: an unknown level of entropy coding");
  for (const uint32_t contexts : {6u, 7u, 9u, 15u})
    EXPECT_EQ(with([&](HeadFields& head) { head.contexts = contexts; }), "head: unknown contexts of symbols");
  EXPECT_EQ(with([](HeadFields& head) { ++head.symbols[2][1]; }),
            "head: frequencies of symbols that do not sum to 4096");
  EXPECT_EQ(with([](HeadFields& head) { head.symbols[1][1] = 1; }),
            "head: frequencies of symbols that do not sum to 4096");
  EXPECT_EQ(with([](HeadFields& head) { head.symbols[0][0] = 0xffffffff; }),
            "head: frequencies of symbols that do not sum to 4096");
  EXPECT_EQ(with([](HeadFields& head) { head.contexts = 5; }),  // more contexts than there are bits
            "head: frequencies of symbols that do not sum to 4096");
  EXPECT_EQ(with([](HeadFields& head) { head.reach = 3; }), "head: an unknown reach");
  EXPECT_EQ(with([](HeadFields& head) { head.more_attributes = 255; }),
            "head: models of more than 256 attributes");
  EXPECT_EQ(with([](HeadFields& head) { head.more_attributes = 33, head.sets_of_each = 8; }),
            "head: more than 256 sets of token tables");
  EXPECT_EQ(with([](HeadFields& head) { head.seam_count = 129; }),
            "head: models of more than 128 attribute data");
  EXPECT_EQ(with([](HeadFields& head) { head.set_count = 8; }), "");
  EXPECT_EQ(with([](HeadFields& head) { head.set_count = 9; }),
            "head: more than 8 sets of token tables for an attribute");
  const std::vector<uint32_t> sums[] = {
      {0xffffffff, 4097}, {4001, 0, 96}, {0, 0, 0}, {0x80000000, 0x80000000, 4096}};
  for (const std::vector<uint32_t>& tokens : sums)
    EXPECT_EQ(with([&](HeadFields& head) { head.tokens = tokens; }),
              "head: frequencies of tokens that do not sum to 4096");
  EXPECT_EQ(with([](HeadFields& head) { head.tokens.assign(117, 1); }),
            "head: a table of more than 116 tokens");
  EXPECT_EQ(with([](HeadFields& head) { head.flag_probability = 0; }), "head: a probability of 0");
  EXPECT_EQ(with([](HeadFields& head) { head.seam_probability = 0; }), "head: a probability of 0");
}

TEST(CondensedHead, HasNoMoreAndNoFewerBits) {
  const std::vector<uint8_t> bytes = write(HeadFields()), tables = write({.has_borders = false});
  for_each_truncation(bytes, [&](const std::vector<uint8_t>& part) {
    EXPECT_EQ(read_condensed_head(part).ok(), part.empty() || part.size() == tables.size()) << part.size();
  });
  // A section that has one more byte.
  std::vector<uint8_t> longer;
  append_head_section(HeadSection::kTables, std::vector<uint8_t>(tables.begin() + 2, tables.end()), longer);
  ASSERT_EQ(longer, tables);
  longer.back() = 0;
  ++longer[1];
  longer.push_back(0);
  EXPECT_FALSE(read_condensed_head(longer));
}

// Sections that a reader does not know, and sections out of order.
TEST(CondensedHead, SkipsSectionsThatMayBeSkipped) {
  const std::vector<uint8_t> tables = write({.has_borders = false});
  const std::vector<uint8_t> data(300, uint8_t{7});
  const auto with = [&](std::vector<uint8_t> head, std::initializer_list<int> types) {
    for (const int type : types) append_head_section(static_cast<HeadSection>(type), data, head);
    const Expected<CondensedHead> read = read_condensed_head(head);
    return read ? std::to_string(read->skeletons.size()) + " skeletons" : read.status().to_string();
  };
  EXPECT_EQ(with({}, {}), "0 skeletons");
  EXPECT_EQ(with({}, {128, 255}), "0 skeletons");
  EXPECT_EQ(with(tables, {128, 200}), "2 skeletons");
  EXPECT_TRUE(contains(with(tables, {4}), "head: section 4 is not known, and may not be skipped"));
  EXPECT_TRUE(contains(with({}, {127}), "head: section 127 is not known"));
  std::vector<uint8_t> head;
  append_head_section(static_cast<HeadSection>(4), data, head);
  EXPECT_EQ(read_condensed_head(head).status().code(), StatusCode::kUnsupported);
  for (const int again : {0, 1})
    EXPECT_TRUE(contains(with(tables, {again}), "head: its sections do not ascend by type"));
  EXPECT_TRUE(contains(with({}, {2}), "head: values at borders without tables"));
  EXPECT_TRUE(contains(with({}, {3}), "head: deltas without tables"));
  for (const std::vector<uint8_t>& broken :
       {std::vector<uint8_t>{128}, {128, 1}, {128, 0x80}, {128, 0x80, 0x80, 0x80, 0x80, 0x80, 0}})
    EXPECT_EQ(read_condensed_head(broken).status().message(), "head: a section of more bytes than there are");
}

// Mutants are refused or read; sanitizers watch.
TEST(CondensedHead, AnyBytesMayBeRead) {
  const std::vector<uint8_t> bytes = write(HeadFields());
  size_t read = 0;
  for (size_t i = 0; i < 8 * bytes.size(); ++i) {
    std::vector<uint8_t> mutant = bytes;
    mutant[i / 8] ^= static_cast<uint8_t>(1u << i % 8);
    const Expected<CondensedHead> head = read_condensed_head(mutant);
    if (!head) continue;
    ++read;
    for (const core::AttributeModel& model : head->attributes)
      EXPECT_LE(uint32_t{model.first_set} + model.set_count, head->table_sets.size());
    for (const core::TableSet& set : head->table_sets)
      for (const uint16_t table : set.tables)
        EXPECT_TRUE(table == core::kNoTable || table < head->token_tables.size());
  }
  EXPECT_GT(read, 50u);
}

}  // namespace
}  // namespace psplit
