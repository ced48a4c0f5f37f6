#include "tools/gltf_psplit/options/backend_choice.h"

#include <gtest/gtest.h>

#include "src/container/patch_container.h"

namespace psplit {
namespace {

PatchContainer container_of(std::span<const uint8_t> bytes, uint32_t patch_count) {
  PatchContainer container;
  container.bytes = bytes;
  container.entries.resize(patch_count);
  return container;
}

TEST(Auto, LeavesTheGpuAloneUnlessThereIsEnoughToDo) {
  const std::vector<uint8_t> bytes(2'000'000);
  const auto is_worth = [&](size_t task_count, uint32_t patch_count, size_t size) {
    const PatchContainer container = container_of(std::span(bytes).first(size), patch_count);
    return is_worth_a_gpu(std::vector<DecodeTask>(task_count, {&container, {}}));
  };
  EXPECT_FALSE(is_worth_a_gpu({}));
  EXPECT_FALSE(is_worth(63, 1, 8192));
  EXPECT_FALSE(is_worth(64, 1, 1024));
  EXPECT_TRUE(is_worth(64, 1, 8192));
  EXPECT_FALSE(is_worth(1, 20, 2'000'000));
  EXPECT_FALSE(is_worth(1, 200, 20'000));
  EXPECT_TRUE(is_worth(1, 200, 400'000));
}

}  // namespace
}  // namespace psplit
