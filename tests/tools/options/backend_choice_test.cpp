#include "tools/gltf_psplit/options/backend_choice.h"

#include <gtest/gtest.h>

#include "src/container/patch_container.h"

namespace psplit {
namespace {

PatchContainer container_of(uint32_t patch_count, uint32_t patch_faces) {
  PatchContainer container;
  container.entries.resize(patch_count);
  for (StreamEntry& entry : container.entries) entry.face_count = patch_faces;
  container.face_base = {0, patch_count * patch_faces};
  container.owned_base = {0, patch_count * patch_faces / 2};
  return container;
}

TEST(Auto, LeavesTheGpuAloneUnlessThereIsEnoughToDo) {
  const std::vector<AttributeRequest> requests(1);
  const auto is_worth = [&](uint32_t patch_count, uint32_t patch_faces, size_t threads, bool is_started) {
    const PatchContainer container = container_of(patch_count, patch_faces);
    const DecodeTask task{&container, requests};
    return is_worth_a_gpu({&task, 1}, threads, is_started);
  };
  EXPECT_FALSE(is_worth_a_gpu({}, 1, true));
  EXPECT_TRUE(is_worth(20'000, 440, 1, true));
  EXPECT_FALSE(is_worth(20'000, 440, 1, false));  // its start takes longer
  EXPECT_TRUE(is_worth(200'000, 440, 1, false));
  EXPECT_FALSE(is_worth(200'000, 440, 16, false));  // enough threads are faster than the way back from a device
  EXPECT_FALSE(is_worth(1, 8'800'000, 1, true));    // one chain of steps
  EXPECT_FALSE(is_worth(20, 440, 1, true));
}

}  // namespace
}  // namespace psplit
