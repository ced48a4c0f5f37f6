#include "tools/gltf_psplit/batch/shard.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/support/expect.h"

namespace psplit {
namespace {

using Variables = std::map<std::string, std::string>;

Expected<Shard> parse(const std::string& text, const Variables& variables = {}) {
  return parse_shard(text, [&](const char* name) {
    const auto found = variables.find(name);
    return found == variables.end() ? nullptr : found->second.c_str();
  });
}
std::string shard(const std::string& text, const Variables& variables = {}) {
  const Expected<Shard> parsed = parse(text, variables);
  return parsed ? parsed->text() : parsed.status().message();
}

TEST(Shard, IsWrittenAsIndexAndCount) {
  EXPECT_EQ(shard("3/128"), "3/128");
  EXPECT_EQ(shard("0/1"), "0/1");
  for (const char* wrong :
       {"", "/", "3", "3/", "/3", "3/3", "-1/3", "3/0", "a/b", "1/2/3", " 1/2", "auto/", "autos"})
    EXPECT_EQ(parse(wrong, {{"JOB_COMPLETION_INDEX", "0"}}).status().code(), StatusCode::kUsage) << wrong;
}

TEST(Shard, ComesFromTheArrayOfAnEngine) {
  EXPECT_EQ(shard("auto", {{"AWS_BATCH_JOB_ARRAY_INDEX", "4"}, {"AWS_BATCH_JOB_ARRAY_SIZE", "9"}}), "4/9");
  EXPECT_EQ(shard("auto/9", {{"JOB_COMPLETION_INDEX", "4"}}), "4/9");
  EXPECT_TRUE(contains(shard("auto", {{"JOB_COMPLETION_INDEX", "4"}}), "write --shard auto/COUNT"));
  EXPECT_TRUE(contains(shard("auto"), "finds no array"));
  EXPECT_TRUE(contains(shard("auto/9", {{"JOB_COMPLETION_INDEX", "4"}, {"SLURM_ARRAY_TASK_ID", "4"}}),
                       "finds two arrays"));
  EXPECT_EQ(parse("auto/9", {{"JOB_COMPLETION_INDEX", "x"}}).status().code(), StatusCode::kUsage);
  EXPECT_EQ(parse("auto/4", {{"JOB_COMPLETION_INDEX", "4"}}).status().code(), StatusCode::kUsage);
}

Variables slurm(const char* id, const char* count, const char* least, const char* most,
                const char* step = "1") {
  return {{"SLURM_ARRAY_TASK_ID", id},
          {"SLURM_ARRAY_TASK_COUNT", count},
          {"SLURM_ARRAY_TASK_MIN", least},
          {"SLURM_ARRAY_TASK_MAX", most},
          {"SLURM_ARRAY_TASK_STEP", step}};
}

// --array=0-7, 1-8, 10-24:2 count from 0; --array=3,7 does not say how many shards there are.
TEST(Shard, CountsSlurmArraysFromZero) {
  EXPECT_EQ(shard("auto", slurm("0", "8", "0", "7")), "0/8");
  EXPECT_EQ(shard("auto", slurm("8", "8", "1", "8")), "7/8");
  EXPECT_EQ(shard("auto", slurm("12", "8", "10", "24", "2")), "1/8");
  EXPECT_TRUE(contains(shard("auto", slurm("7", "2", "3", "7")), "do not follow each other"));
  EXPECT_EQ(shard("auto/8", slurm("7", "2", "3", "7")), "7/8");
}

TEST(Shard, EveryNameBelongsToOneAndAllGetTheirPart) {
  constexpr uint32_t kShards = 7, kNames = 7000;
  std::map<uint32_t, int> names;
  for (uint32_t i = 0; i < kNames; ++i) {
    int owners = 0;
    for (uint32_t index = 0; index < kShards; ++index)
      if (Shard{index, kShards}.owns("x/" + std::to_string(i) + ".glb")) {
        ++owners;
        ++names[index];
      }
    ASSERT_EQ(owners, 1) << i;
  }
  for (uint32_t index = 0; index < kShards; ++index) EXPECT_NEAR(names[index], 1000, 150);
  EXPECT_TRUE(Shard().owns("anything"));
}

}  // namespace
}  // namespace psplit
