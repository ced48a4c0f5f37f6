#include "decoder_cuda/psplit_cuda.h"

#include <gtest/gtest.h>

#include <random>

#include "encoder/draco/draco_backend.h"
#include "src/cpu/cpu_backend.h"
#include "tests/support/patched_samples.h"

namespace psplit {
namespace {

TEST(Cuda, SaysWhyItIsNotAvailable) {
  std::string why = "untouched";
  const bool available = cuda_available(&why);
  EXPECT_EQ(why.empty(), available) << why;
  EXPECT_NE(why, "untouched");
  EXPECT_EQ(cuda_available(nullptr), available);
}

TEST(Cuda, EqualsLibdraco) {
  std::string why;
  if (!cuda_available(&why)) GTEST_SKIP() << why;
  const ThreadPool pool;
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    const Expected<Mesh> expected =
        draco_backend().decode_container(sample.encoded.container, sample.requests, pool);
    const Expected<Mesh> decoded =
        cuda_backend().decode_container(sample.encoded.container, sample.requests, pool);
    ASSERT_TRUE(expected) << expected.status().to_string();
    ASSERT_TRUE(decoded) << decoded.status().to_string();
    EXPECT_TRUE(same_bits(*decoded, *expected));
  }
}

// Broken containers are refused or decode as on the CPU, and leave the device fit for the next.
TEST(Cuda, TakesAndRefusesMutantsAsTheCpuDoes) {
  std::string why;
  if (!cuda_available(&why)) GTEST_SKIP() << why;
  const ThreadPool pool;
  const std::vector<PatchedSample> seeds = patched_samples(pool);
  std::mt19937 random(2);
  for (int i = 0; i < 1500; ++i) {
    const PatchedSample& seed = seeds[random() % seeds.size()];
    std::vector<uint8_t> bytes = seed.encoded.container;
    bytes[random() % (random() % 2 == 0 ? bytes.size() : std::min<size_t>(bytes.size(), 300))] =
        static_cast<uint8_t>(random());
    const Expected<Mesh> expected = cpu_backend().decode_container(bytes, seed.requests, pool);
    const Expected<Mesh> decoded = cuda_backend().decode_container(bytes, seed.requests, pool);
    ASSERT_EQ(decoded.ok(), expected.ok())
        << seed.name << ", mutant " << i << ": " << (decoded ? expected : decoded).status().to_string();
    EXPECT_TRUE(!decoded || same_bits(*decoded, *expected)) << seed.name << ", mutant " << i;
  }
}

}  // namespace
}  // namespace psplit
