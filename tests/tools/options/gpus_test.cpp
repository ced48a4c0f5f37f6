
#include "tests/support/expect.h"
#include "tools/gltf_psplit/options/encode_options.h"

namespace psplit {
namespace {

TEST(Gpus, AreKnownByNameOrBySize) {
  EXPECT_EQ(multiprocessors("H100"), 132u);
  EXPECT_EQ(multiprocessors("rtx4090"), 128u);
  EXPECT_EQ(multiprocessors("RTX 4090"), 128u);
  EXPECT_EQ(multiprocessors("60"), 60u);
  for (const char* unknown : {"", "0", "-1", "4097", "Voodoo", "H100x", "12a"})
    EXPECT_FALSE(multiprocessors(unknown)) << unknown;
  EXPECT_TRUE(contains(known_gpus(), "H200, H100"));
}

TEST(Gpus, TakePatchesInMultiplesOf512) {
  EXPECT_EQ(patches_in_flight(132), 16896u);
  EXPECT_EQ(patches_in_flight(1), 512u);
  for (uint32_t count = 1; count < 200; ++count) EXPECT_EQ(patches_in_flight(count) % 512, 0u);
}

}  // namespace
}  // namespace psplit
