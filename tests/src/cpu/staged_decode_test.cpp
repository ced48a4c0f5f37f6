#include "src/cpu/staged_decode.h"

#include <gtest/gtest.h>

#include <cstring>

#include "psplit/encode.h"
#include "tests/support/expect.h"
#include "tests/support/patched_samples.h"

namespace psplit {
namespace {

// The output is patch after patch, and in each patch attribute after attribute, in the order of the stream.
TEST(StagedDecode, GivesTheFacesAndValuesOfLibdraco) {
  const ThreadPool pool(2);
  size_t timed = 0;
  for (const PatchedSample& sample : all_samples(pool)) {
    SCOPED_TRACE(sample.name);
    for (const bool in_step : {false, true}) {
      StagedInput input(*open_container(sample.encoded.pieces[0].bytes), sample.requests);
      StageTimes times;
      ASSERT_TRUE(decode_with_core(input, in_step, times).ok());
      size_t face = 0, byte = 0;
      for (uint32_t i = 0; i < input.container.patch_count(); ++i) {
        const auto patch = must(draco_backend().decode(input.container.alone(i), sample.requests, pool));
        ASSERT_LE(face + patch.faces.size(), input.faces.size());
        EXPECT_EQ(std::memcmp(input.faces.data() + face, patch.faces.data(), 12 * patch.faces.size()), 0);
        face += patch.faces.size();
        size_t values_bytes = 0;
        for (const Attribute& attribute : patch.attributes) values_bytes += attribute.values.size();
        ASSERT_LE(byte + values_bytes, input.values.size());
        if (patch.attributes.size() == 1) {
          EXPECT_EQ(std::memcmp(input.values.data() + byte, patch.attributes[0].values.data(), values_bytes),
                    0);
        }
        byte += values_bytes;
      }
      if (face == 0) continue;  // there is only a residue
      ++timed;
      EXPECT_GT(times.connectivity_ms, 0);
      EXPECT_GT(times.chains_ms, 0);
      EXPECT_GT(times.prediction_ms, 0);
      EXPECT_GT(times.output_ms, 0);
    }
  }
  EXPECT_GT(timed, 20u);
}

}  // namespace
}  // namespace psplit
