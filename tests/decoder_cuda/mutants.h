// Broken containers: a decoder must refuse each container that the CPU backend refuses, and decode the others
// to the same bits.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "psplit/decode.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/patched_samples.h"
#include "tests/support/same_bits.h"

namespace psplit {

// decode(container, requests) is an Expected<Mesh>.
template <typename Decode>
void expect_mutants_as_on_cpu(Decode decode, int count = 3000) {
  const ThreadPool pool(1);
  const std::vector<PatchedSample>& seeds = all_samples(pool);
  std::mt19937 random(2);
  size_t accepted = 0;
  for (int i = 0; i < count; ++i) {
    const PatchedSample& seed = seeds[random() % seeds.size()];
    if (seed.encoded.pieces[0].bytes.size() > 10'000) continue;
    std::vector<uint8_t> bytes = seed.encoded.pieces[0].bytes;
    bytes[random() % (random() % 2 == 0 ? bytes.size() : std::min<size_t>(bytes.size(), 300))] =
        static_cast<uint8_t>(random());
    const Expected<Mesh> expected = decode_container(cpu_backend(), bytes, seed.requests, pool);
    const Expected<Mesh> decoded = decode(bytes, seed.requests);
    // A mutant may have another data type. The CPU converts its values; a device refuses it.
    if (expected && decoded.status().code() == StatusCode::kUnsupported) continue;
    ASSERT_EQ(decoded.ok(), expected.ok())
        << seed.name << ", mutant " << i << ": " << (decoded ? expected : decoded).status().to_string();
    if (!decoded) continue;
    ++accepted;
    EXPECT_TRUE(same_bits(*decoded, *expected)) << seed.name << ", mutant " << i;
  }
  EXPECT_GT(accepted, static_cast<size_t>(count / 30));
}

}  // namespace psplit
