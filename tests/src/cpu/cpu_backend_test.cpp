// The CPU backend against libdraco's, over whole containers. Stock streams:
// tests/src/loader/draco_stream_test.cpp.
#include <algorithm>
#include <cstring>
#include <random>

#include "encoder/encode_mesh.h"
#include "psplit/decode.h"
#include "psplit/encode.h"
#include "src/cpu/checked_decode.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/patched_samples.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/same_bits.h"

namespace psplit {
namespace {

TEST(CpuBackend, EqualsLibdracoForAnyNumberOfThreads) {
  const ThreadPool one(1), seven(7);
  for (const std::vector<PatchedSample>* samples : {&all_samples(seven), &large_samples(seven)})
    for (const PatchedSample& sample : *samples)
      for (const ThreadPool* pool : {&one, &seven}) {
        SCOPED_TRACE(sample.name);
        const Mesh decoded =
            must(decode_container(cpu_backend(), sample.encoded.pieces[0].bytes, sample.requests, *pool));
        EXPECT_TRUE(same_bits(decoded, sample.mesh));
        // A checked decode returns the same mesh, and no findings for a valid container.
        const PatchContainer container = must(open_container(sample.encoded.pieces[0].bytes));
        const CheckedMesh checked = must(decode_checked(container, sample.requests, *pool));
        EXPECT_TRUE(same_bits(checked.mesh, sample.mesh));
        ASSERT_EQ(checked.streams.size(), container.entries.size());
        for (const StreamFindings& stream : checked.streams) {
          EXPECT_TRUE(stream.types.ok()) << stream.types.to_string();
          EXPECT_TRUE(stream.copies.ok()) << stream.copies.to_string();
        }
      }
}

// A checked decode has a finding for each stream that breaks a rule.
TEST(CheckedDecode, FindsAttributesOfAnotherTypeInEachStream) {
  const ThreadPool pool(3);
  for (const PatchedSample& sample : all_samples(pool)) {
    SCOPED_TRACE(sample.name);
    std::vector<AttributeRequest> requests = sample.requests;
    AttributeRequest& position = requests.front();
    if (position.component_type != ComponentType::kFloat32) continue;
    position.component_type = ComponentType::kInt16;
    const PatchContainer container = must(open_container(sample.encoded.pieces[0].bytes));
    const Expected<CheckedMesh> checked = decode_checked(container, requests, pool);
    if (!checked) continue;  // a value does not fit
    for (size_t i = 0; i < checked->streams.size(); ++i) {
      EXPECT_EQ(checked->streams[i].types.place().patch, static_cast<int64_t>(i));
      EXPECT_TRUE(checked->streams[i].types.message().starts_with(position.semantic));
    }
  }
}

// Symbols of more than 18 bits, predictions outside the grid, and texture coordinates whose prediction would
// overflow. Condensed and not, with all prediction schemes that the speeds choose.
TEST(CpuBackend, DecodesFineGridsAsLibdracoDoes) {
  const ThreadPool pool(1);
  const Mesh mesh = long_edges();
  for (const int bits : {15, 17, 18, 19, 20, 21, 22, 24})
    for (const int speed : {0, 1, 3, 5, 10}) {
      if (bits > 22 && speed < 5) continue;  // libdraco counts symbols in tables of 2^bits entries
      SCOPED_TRACE(std::to_string(bits) + " bits, speed " + std::to_string(speed));
      for (const bool condense : {false, true}) {
        const StreamOptions options{
            .patch_count = 3, .encode_speed = speed, .condense = condense, .verify = false};
        const EncodedMesh encoded = must(encode_mesh(mesh, fine_codings(mesh, bits), options, pool));
        const auto expected =
            must(decode_container(draco_backend(), encoded.pieces[0].bytes, encoded.requests, pool));
        const auto decoded =
            must(decode_container(cpu_backend(), encoded.pieces[0].bytes, encoded.requests, pool));
        EXPECT_TRUE(same_bits(decoded, expected));
      }
    }
}

TEST(CpuBackend, ConvertsToTheTypeThatIsAskedFor) {
  const ThreadPool pool(1);
  for (const PatchedSample& sample : all_samples(pool)) {
    SCOPED_TRACE(sample.name);
    std::vector<AttributeRequest> requests = sample.requests;
    for (const ComponentType type : {ComponentType::kFloat32, ComponentType::kUint8, ComponentType::kInt16}) {
      for (AttributeRequest& request : requests) request.component_type = type;
      const auto expected = decode_container(draco_backend(), sample.encoded.pieces[0].bytes, requests, pool);
      const auto decoded = decode_container(cpu_backend(), sample.encoded.pieces[0].bytes, requests, pool);
      ASSERT_EQ(decoded.ok(), expected.ok()) << decoded.status().to_string();
      if (!decoded) continue;
      EXPECT_TRUE(same_bits(*decoded, *expected));
    }
  }
}

TEST(CpuBackend, RefusesMutantsAsLibdracoDoesOrBefore) {
  const ThreadPool pool(1);
  const std::vector<PatchedSample>& seeds = all_samples(pool);
  std::mt19937 random(1);
  size_t accepted = 0;
  for (int i = 0; i < 2000; ++i) {
    const PatchedSample& seed = seeds[random() % seeds.size()];
    if (seed.encoded.pieces[0].bytes.size() > 20'000) continue;
    std::vector<uint8_t> bytes = seed.encoded.pieces[0].bytes;
    for (int edits = 1 + static_cast<int>(random() % 2); edits > 0; --edits)
      bytes[random() % (random() % 2 == 0 ? bytes.size() : std::min<size_t>(bytes.size(), 200))] =
          static_cast<uint8_t>(random());
    const Expected<Mesh> decoded = decode_container(cpu_backend(), bytes, seed.requests, pool);
    if (!decoded) continue;
    // libdraco is slow on broken streams: it takes memory according to their claims.
    if (++accepted % 4 != 0) continue;
    const Expected<Mesh> expected = decode_container(draco_backend(), bytes, seed.requests, pool);
    EXPECT_TRUE(!expected || same_bits(*decoded, *expected)) << seed.name << ", mutant " << i;
  }
  EXPECT_GT(accepted, 40u);
}

TEST(CpuBackend, SaysWhatIsWrongAndInWhichPatch) {
  const ThreadPool pool(1);
  const std::vector<PatchedSample>& all = patched_samples(pool);
  const auto sample = std::find_if(all.begin(), all.end(),
                                   [](const PatchedSample& s) { return s.encoded.statistics.patch_count > 2; });
  ASSERT_NE(sample, all.end());
  // No stream is Draco any more. The error names the first patch.
  std::vector<uint8_t> bytes = sample->encoded.pieces[0].bytes;
  for (size_t i = 0; i + 5 <= bytes.size(); ++i)
    if (std::memcmp(&bytes[i], "DRACO", 5) == 0) bytes[i] = 'd';
  const Status broken = decode_container(cpu_backend(), bytes, sample->requests, pool).status();
  EXPECT_EQ(broken.to_string(), "patch 0: Draco stream: not a Draco mesh");
  std::vector<AttributeRequest> requests = sample->requests;
  requests[0].unique_id = 77;
  const Status missing =
      decode_container(cpu_backend(), sample->encoded.pieces[0].bytes, requests, pool).status();
  EXPECT_EQ(missing.code(), StatusCode::kInvalidInput);
  EXPECT_EQ(missing.place().patch, 0);
  EXPECT_TRUE(contains(missing.message(), "unique id 77"));
}

}  // namespace
}  // namespace psplit
