// The CPU backend against libdraco's, over whole containers and stock streams.
#include "src/cpu/cpu_backend.h"

#include <algorithm>
#include <cstring>
#include <random>

#include "encoder/draco/draco_backend.h"
#include "encoder/encode_mesh.h"
#include "src/container/claims.h"
#include "src/container/stream_description.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/draco_streams.h"
#include "tests/support/patched_samples.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

TEST(CpuBackend, EqualsLibdracoForAnyNumberOfThreads) {
  const ThreadPool one(1), seven(7);
  for (const PatchedSample& sample : all_samples(seven)) {
    SCOPED_TRACE(sample.name);
    const Mesh expected =
        must(decode_container(draco_backend(), sample.encoded.container, sample.requests, one));
    for (const ThreadPool* pool : {&one, &seven}) {
      const Mesh decoded =
          must(decode_container(cpu_backend(), sample.encoded.container, sample.requests, *pool));
      EXPECT_TRUE(same_bits(decoded, expected));
    }
  }
}

TEST(CpuBackend, DecodesStockStreamsAsLibdracoDoes) {
  size_t equal = 0, converted = 0;
  for_each_draco_stream(
      [&](const DracoStream& stream) {
        SCOPED_TRACE(stream.name);
        const auto description = must(describe_stream(stream.bytes));
        const auto requests = gltf_attributes(description.attributes);
        if (!requests) return;  // no glTF asset can hold it
        const auto expected = decode_stream(draco_backend(), stream.bytes, *requests);
        const auto decoded = decode_stream(cpu_backend(), stream.bytes, *requests);
        // Neither decoder converts a number that the requested type cannot hold.
        ASSERT_EQ(decoded.ok(), expected.ok()) << decoded.status().to_string();
        if (!decoded) return;
        EXPECT_TRUE(same_bits(*decoded, *expected));
        ++equal;
        for (const StreamAttribute& attribute : description.attributes)
          converted += attribute.type == core::DataType::kInt32 || attribute.type == core::DataType::kFloat64;
      },
      StreamSet::kSmall);
  EXPECT_GT(equal, 100u);
  EXPECT_GT(converted, 0u);
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
        const EncodeOptions options{
            .patch_count = 3, .encode_speed = speed, .condense = condense, .verify = false};
        const EncodedMesh encoded = must(encode_mesh(mesh, fine_codings(mesh, bits), options, pool));
        const auto expected =
            must(decode_container(draco_backend(), encoded.container, encoded.requests, pool));
        const auto decoded = must(decode_container(cpu_backend(), encoded.container, encoded.requests, pool));
        EXPECT_TRUE(same_bits(decoded, expected));
      }
    }
}

TEST(CpuBackend, ConvertsToTheTypeThatIsAskedFor) {
  const ThreadPool pool(1);
  for (PatchedSample& sample : all_samples(pool)) {
    SCOPED_TRACE(sample.name);
    for (const ComponentType type : {ComponentType::kFloat32, ComponentType::kUint8, ComponentType::kInt16}) {
      for (AttributeRequest& request : sample.requests) request.component_type = type;
      const auto expected = decode_container(draco_backend(), sample.encoded.container, sample.requests, pool);
      const auto decoded = decode_container(cpu_backend(), sample.encoded.container, sample.requests, pool);
      ASSERT_EQ(decoded.ok(), expected.ok()) << decoded.status().to_string();
      if (!decoded) continue;
      EXPECT_TRUE(same_bits(*decoded, *expected));
    }
  }
}

TEST(CpuBackend, RefusesBrokenContainersAsLibdracoDoesOrBefore) {
  const ThreadPool pool(1);
  const std::vector<PatchedSample> seeds = all_samples(pool);
  std::mt19937 random(1);
  size_t accepted = 0;
  for (int i = 0; i < 2000; ++i) {
    const PatchedSample& seed = seeds[random() % seeds.size()];
    if (seed.encoded.container.size() > 20'000) continue;
    std::vector<uint8_t> bytes = seed.encoded.container;
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

// A directory that claims more than its streams is refused before memory is taken for it.
TEST(CpuBackend, RefusesClaimsBeforeItAllocates) {
  const ThreadPool pool(1);
  const PatchedSample sample = patched_samples(pool).front();
  const PatchContainer container = must(open_container(sample.encoded.container));
  ContainerParts parts(container);
  parts.entries[0].face_count = 0x50000000;
  std::vector<uint8_t> bytes = parts.write();
  const Status status = open_container(bytes).status();
  EXPECT_EQ(status.code(), StatusCode::kInvalidInput);
  EXPECT_EQ(status.place().patch, 0);
  parts.entries[0] = container.entries[0];
  parts.entries[0].point_count = 0x50000000;
  bytes = parts.write();
  EXPECT_EQ(open_container(bytes).status().code(), StatusCode::kInvalidInput);
}

// A residue may own no points, but its references take memory.
TEST(CpuBackend, RefusesResiduesThatClaimOtherPoints) {
  const ThreadPool pool(1);
  size_t count = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    const PatchContainer container = must(open_container(sample.encoded.container));
    if (!container.has_residue) continue;
    ++count;
    ContainerParts parts(container);
    parts.entries.back().point_count += 0x70000000;
    parts.entries.back().reference_count += 0x70000000;
    const std::vector<uint8_t> bytes = parts.write();
    EXPECT_TRUE(check_directory(bytes).ok());
    const Status status = open_container(bytes).status();
    EXPECT_EQ(status.code(), StatusCode::kInvalidInput);
    EXPECT_EQ(status.place().patch, static_cast<int64_t>(parts.entries.size()) - 1);
  }
  EXPECT_GT(count, 0u);
}

// Only the residue has no border walk. A flag says which stream is the residue, so the stream must agree.
TEST(PatchContainer, RefusesAFlagOfTheResidueThatIsWrong) {
  const ThreadPool pool(1);
  size_t residues = 0, patches = 0;
  for (const PatchedSample& sample : patched_samples(pool)) {
    const PatchContainer container = must(open_container(sample.encoded.container));
    std::vector<uint8_t> bytes = sample.encoded.container;
    bytes[5] ^= 1;
    if (!check_directory(bytes).ok()) continue;
    const Status status = open_container(bytes).status();
    EXPECT_EQ(status.code(), StatusCode::kInvalidInput) << sample.name;
    EXPECT_EQ(status.place().patch, static_cast<int64_t>(container.entries.size()) - 1);
    EXPECT_EQ(status.message(), container.has_residue ? "a patch is not an Edgebreaker mesh"
                                                      : "the residue is not a sequential mesh");
    ++(container.has_residue ? residues : patches);
  }
  EXPECT_GT(residues, 0u);
  EXPECT_GT(patches, 0u);
}

TEST(CpuBackend, SaysWhatIsWrongAndInWhichPatch) {
  const ThreadPool pool(1);
  const std::vector<PatchedSample> all = patched_samples(pool);
  const auto sample = std::find_if(all.begin(), all.end(),
                                   [](const PatchedSample& s) { return s.encoded.statistics.patch_count > 2; });
  ASSERT_NE(sample, all.end());
  // No stream is Draco any more. The error names the first patch.
  std::vector<uint8_t> bytes = sample->encoded.container;
  for (size_t i = 0; i + 5 <= bytes.size(); ++i)
    if (std::memcmp(&bytes[i], "DRACO", 5) == 0) bytes[i] = 'd';
  const Status broken = decode_container(cpu_backend(), bytes, sample->requests, pool).status();
  EXPECT_EQ(broken.to_string(), "patch 0: Draco stream: not a Draco mesh");
  std::vector<AttributeRequest> requests = sample->requests;
  requests[0].unique_id = 77;
  const Status missing = decode_container(cpu_backend(), sample->encoded.container, requests, pool).status();
  EXPECT_EQ(missing.code(), StatusCode::kInvalidInput);
  EXPECT_EQ(missing.place().patch, 0);
  EXPECT_NE(missing.message().find("unique id 77"), std::string::npos) << missing.message();
}

}  // namespace
}  // namespace psplit
