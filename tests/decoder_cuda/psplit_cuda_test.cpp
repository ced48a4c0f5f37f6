#include "psplit/cuda.h"
#include "tests/decoder_cuda/mutants.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/same_bits.h"

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
  const DecodeBackend cuda = cuda_backend();
  for (const std::vector<PatchedSample>* samples : {&patched_samples(pool), &large_samples(pool)})
    for (const PatchedSample& sample : *samples) {
      SCOPED_TRACE(sample.name);
      const Mesh decoded = must(decode_container(cuda, sample.encoded.pieces[0].bytes, sample.requests, pool));
      EXPECT_TRUE(same_bits(decoded, sample.mesh));
    }
}

// Broken containers are refused or decode as on the CPU, and leave the device fit for the next.
void expect_mutants_on_device(int count) {
  std::string why;
  if (!cuda_available(&why)) GTEST_SKIP() << why;
  expect_mutants_as_on_cpu(
      [cuda = cuda_backend()](std::span<const uint8_t> bytes, std::span<const AttributeRequest> requests) {
        return decode_container(cuda, bytes, requests, ThreadPool(1));
      },
      count);
}

TEST(Cuda, TakesAndRefusesMutantsAsTheCpuDoes) { expect_mutants_on_device(3000); }

// For simulated devices, which are slow.
TEST(CudaQuick, TakesAndRefusesMutantsAsTheCpuDoes) { expect_mutants_on_device(30); }

}  // namespace
}  // namespace psplit
