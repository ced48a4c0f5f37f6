// Patches whose tokens are alike share a set of tables.
#include "encoder/condensing/table_sets.h"

#include <gtest/gtest.h>

#include <random>

namespace psplit {
namespace {

// Patches of `kinds` kinds, in turn.
std::vector<PatchTokens> patches_of_kinds(size_t count, size_t kinds) {
  std::mt19937 random(1);
  std::vector<PatchTokens> patches;
  for (size_t i = 0; i < count; ++i) {
    AttributeCounts counts;
    for (int n = 0; n < 1000; ++n) ++counts.tokens[random() % 3][20 * (i % kinds) + random() % 8];
    patches.push_back(patch_tokens(counts));
  }
  return patches;
}

TEST(TableSets, PatchTokensAreThoseThatOccur) {
  AttributeCounts counts;
  counts.tokens[0][3] = 7;
  counts.tokens[2][core::kTokenCount - 1] = 1;
  const PatchTokens tokens = patch_tokens(counts);
  ASSERT_EQ(tokens.size(), 2u);
  EXPECT_TRUE(tokens[0].table == 0 && tokens[0].token == 3 && tokens[0].count == 7);
  EXPECT_TRUE(tokens[1].table == 2 && tokens[1].token == core::kTokenCount - 1 && tokens[1].count == 1);
}

TEST(TableSets, PatchesThatAreAlikeShareASet) {
  const std::vector<PatchTokens> patches = patches_of_kinds(90, 4);
  const TableSets sets = choose_table_sets(patches, 8, false, ThreadPool(1));
  ASSERT_EQ(sets.counts.size(), 4u);
  for (size_t i = 4; i < patches.size(); ++i) EXPECT_EQ(sets.set[i], sets.set[i % 4]) << i;
  std::vector<AttributeCounts> counts(4);
  for (size_t i = 0; i < patches.size(); ++i)
    for (const auto [table, token, count] : patches[i]) counts[sets.set[i]].tokens[table][token] += count;
  for (size_t s = 0; s < 4; ++s) EXPECT_EQ(counts[s].tokens, sets.counts[s].tokens);
  const TableSets several = choose_table_sets(patches, 8, false, ThreadPool(5));
  EXPECT_EQ(several.set, sets.set);
}

TEST(TableSets, AreNoMoreThanPayOrAreAllowed) {
  const auto set_count = [](size_t patches, size_t kinds, uint32_t most) {
    return choose_table_sets(patches_of_kinds(patches, kinds), most, true, ThreadPool(1)).counts.size();
  };
  EXPECT_EQ(set_count(80, 1, 8), 1u);
  EXPECT_EQ(set_count(80, 4, 8), 4u);
  EXPECT_EQ(set_count(80, 4, 3), 2u);
  EXPECT_EQ(set_count(80, 4, 1), 1u);
  EXPECT_EQ(set_count(1, 1, 8), 1u);
  EXPECT_EQ(set_count(0, 1, 8), 1u);
}

}  // namespace
}  // namespace psplit
