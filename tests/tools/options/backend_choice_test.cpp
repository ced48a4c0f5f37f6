#include "tools/gltf_psplit/options/backend_choice.h"

#include <gtest/gtest.h>

#include "src/container/container.h"

namespace psplit {
namespace {

std::vector<uint8_t> container_of(uint32_t patch_count, uint32_t stream_bytes) {
  const std::vector<StreamEntry> entries(patch_count, {stream_bytes, 1, 3, 0, 0});
  const std::vector<std::vector<uint8_t>> stitch(patch_count);
  return write_container(entries, false, stitch, std::vector(patch_count, std::vector<uint8_t>(stream_bytes)));
}

TEST(Auto, LeavesTheGpuAloneUnlessThereIsEnoughToDo) {
  const std::vector<uint8_t> stream(8192);
  const auto streams = [&](size_t count, size_t bytes) {
    return std::vector<DecodeTask>(count, {std::span(stream).first(bytes), true, {}});
  };
  EXPECT_FALSE(is_worth_a_gpu({}));
  EXPECT_FALSE(is_worth_a_gpu(streams(63, 8192)));
  EXPECT_FALSE(is_worth_a_gpu(streams(64, 1024)));
  EXPECT_TRUE(is_worth_a_gpu(streams(64, 8192)));

  const auto is_worth = [](const std::vector<uint8_t>& container) {
    const DecodeTask task{container, false, {}};
    return is_worth_a_gpu({&task, 1});
  };
  EXPECT_FALSE(is_worth(container_of(20, 100'000)));
  EXPECT_FALSE(is_worth(container_of(200, 100)));
  EXPECT_TRUE(is_worth(container_of(200, 2000)));
  EXPECT_FALSE(is_worth(std::vector<uint8_t>(1'000'000)));  // not a container
}

}  // namespace
}  // namespace psplit
