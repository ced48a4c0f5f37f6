// The whole decoder of a device but for the device: every body of its kernels by the emulated warp, in several
// orders, against libdraco.
#include "decoder_cuda/batch_decoder.h"

#include <gtest/gtest.h>

#include "encoder/draco/draco_backend.h"
#include "tests/decoder_cuda/emulated_device.h"
#include "tests/support/patched_samples.h"

namespace psplit {
namespace {

TEST(BatchDecoder, EqualsLibdracoInEveryOrderOfThreadsAndLanes) {
  const ThreadPool pool(2);
  std::vector<BatchDecoder<EmulatedDevice>> decoders;
  for (const LaneOrder& order : kLaneOrders) decoders.emplace_back(EmulatedDevice(order));
  size_t count = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    SCOPED_TRACE(sample.name);
    const std::vector<uint8_t>& container = sample.encoded.container;
    const Expected<Mesh> expected = draco_backend().decode_container(container, sample.requests, pool);
    ASSERT_TRUE(expected) << expected.status().to_string();
    const Expected<Mesh> decoded =
        decode_to_host(decoders[count++ % decoders.size()], container, sample.requests);
    ASSERT_TRUE(decoded) << decoded.status().to_string();
    EXPECT_TRUE(same_bits(*decoded, *expected));
  }
}

}  // namespace
}  // namespace psplit
