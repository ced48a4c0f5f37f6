// Containers of version 3 from encode_mesh: they hold the streams of version 2, and any change of their front
// is an error or another container.
#include <gtest/gtest.h>

#include <random>

#include "encoder/coding/quantization.h"
#include "encoder/draco/draco_backend.h"
#include "encoder/encode_mesh.h"
#include "src/condensed/expand_container.h"
#include "src/container/condensed_head.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/patched_samples.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

std::vector<AttributeCoding> codings_of(const Mesh& mesh, bool lossless) {
  std::vector<AttributeCoding> codings;
  for (const Attribute& attribute : mesh.attributes) {
    AttributeCoding coding;
    if (!lossless && attribute.component_type == ComponentType::kFloat32) {
      const Expected<AttributeCoding> grid = fit_grid(attribute, 12);
      if (attribute.semantic == "NORMAL") {
        coding.bits = 10;
        coding.octahedral = true;
      } else if (grid.ok()) {
        coding = *grid;
      }
    }
    codings.push_back(std::move(coding));
  }
  return codings;
}

Expected<EncodedMesh> encode(const Mesh& mesh, const EncodeOptions& options, bool lossless = false,
                             int threads = 2) {
  return encode_mesh(mesh, codings_of(mesh, lossless), options, ThreadPool(threads));
}

std::vector<NamedMesh> catalogue() {
  std::vector<NamedMesh> meshes = procedural_meshes();
  for (NamedMesh& nasty : nasty_meshes()) meshes.push_back(std::move(nasty));
  return meshes;
}

// A grid in several patches, all of them condensed.
EncodedMesh condensed_grid() {
  EncodeOptions options;
  options.patch_count = 9;
  options.condense = true;
  EncodedMesh encoded = std::move(*encode(make_grid(60, 60), options));
  EXPECT_EQ(encoded.opened->version, kCondensedContainerVersion);
  EXPECT_EQ(encoded.opened->condensed_count(), 9u);
  return encoded;
}

TEST(EncodeCondensed, ExpandsToTheContainerOfVersion2) {
  const ThreadPool pool(2);
  size_t condensed_count = 0;
  uint32_t round = 0;
  for (const NamedMesh& named : catalogue())
    for (const bool lossless : {false, true}) {
      SCOPED_TRACE(named.name);
      EncodeOptions options;
      options.patch_count = 1 + round++ % 7;
      options.encode_speed = static_cast<int>(round * 3 % 11);
      const Expected<EncodedMesh> plain = encode(named.mesh, options, lossless);
      options.condense = true;
      options.condense_smallest = round % 2 == 0;
      const Expected<EncodedMesh> condensed = encode(named.mesh, options, lossless);
      ASSERT_TRUE(plain && condensed) << plain.status().to_string() << condensed.status().to_string();
      if (condensed->opened->version == kContainerVersion) {
        EXPECT_EQ(condensed->container, plain->container);
        continue;
      }
      ++condensed_count;
      EXPECT_LT(condensed->container.size(), plain->container.size());
      const auto expanded = expand_container(*condensed->opened, pool);
      ASSERT_TRUE(expanded.ok()) << expanded.status().to_string();
      EXPECT_EQ(*expanded, plain->container);
      EXPECT_EQ(condensed->source_point, plain->source_point);
      EXPECT_TRUE(same_bits(*condensed->decoded, *plain->decoded));
      for (uint32_t i = 0; i < condensed->opened->entries.size(); ++i) {
        const PatchContainer alone = condensed->opened->alone(i);
        const Expected<Mesh> patch = draco_backend().decode(alone, condensed->requests, pool);
        ASSERT_TRUE(patch.ok()) << patch.status().to_string();
        EXPECT_TRUE(
            same_bits(*patch, *draco_backend().decode(plain->opened->alone(i), condensed->requests, pool)));
      }
    }
  EXPECT_GT(condensed_count, 10u);
}

TEST(EncodeCondensed, ThreadsDoNotChangeTheBytes) {
  EncodeOptions options;
  options.patch_count = 9;
  options.condense = true;
  const Mesh mesh = make_grid(60, 60);
  EXPECT_EQ(encode(mesh, options, false, 1)->container, encode(mesh, options, false, 5)->container);
}

// A single stream needs no container, so it is condensed only if that is smaller than the stream alone.
TEST(EncodeCondensed, ASmallMeshStaysAsItIs) {
  EncodeOptions options;
  options.condense = true;
  const Expected<EncodedMesh> encoded = encode(make_grid(2, 2), options);
  ASSERT_TRUE(encoded.ok());
  EXPECT_EQ(encoded->opened->version, kContainerVersion);
}

TEST(EncodeCondensed, RefusesEveryTruncation) {
  const std::vector<uint8_t> bytes = condensed_grid().container;
  for (size_t length = 0; length < bytes.size(); ++length) {
    const std::vector<uint8_t> part(bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(length));
    EXPECT_FALSE(open_container(part).ok()) << length;
  }
}

TEST(EncodeCondensed, RefusesAResidueThatIsCondensed) {
  std::vector<uint8_t> bytes = condensed_grid().container;
  bytes[5] = 1;
  const Status status = open_container(bytes).status();
  EXPECT_EQ(status.message(), "directory: the residue is condensed");
  EXPECT_EQ(status.place().patch, 8);
}

TEST(EncodeCondensed, RefusesAHeadWithoutCondensedStreams) {
  const EncodedMesh encoded = condensed_grid();
  const PatchContainer& condensed = *encoded.opened;
  std::vector<StreamEntry> entries = condensed.entries;
  std::vector<std::vector<uint8_t>> stitch, streams;
  for (uint32_t i = 0; i < entries.size(); ++i) {
    stitch.emplace_back(condensed.stitch[i].begin(), condensed.stitch[i].end());
    streams.push_back(*expand_patch(condensed, i));
    entries[i].is_condensed = false;
    entries[i].stream_bytes = static_cast<uint32_t>(streams.back().size());
  }
  const std::span<const uint8_t> head =
      condensed.bytes.subspan(condensed.header_bytes - condensed.head_bytes, condensed.head_bytes);
  const auto with_head = write_condensed_container(entries, false, head, stitch, streams);
  EXPECT_EQ(open_container(*with_head).status().message(), "container: a head, but no condensed stream");
  const auto without = write_condensed_container(entries, false, {}, stitch, streams);
  EXPECT_TRUE(open_container(*without).ok());
}

// Mutants of all bytes: an error with its place, or another container. Whatever opens can be expanded or says
// why not, and takes memory in proportion to its bytes.
TEST(EncodeCondensed, MutantsAreErrorsOrOtherContainers) {
  const std::vector<uint8_t> bytes = condensed_grid().container;
  const uint64_t front = condensed_grid().opened->header_bytes;
  const ThreadPool pool(1);
  std::mt19937 random(3);
  size_t opened = 0, expanded = 0;
  for (int round = 0; round < 3000; ++round) {
    std::vector<uint8_t> mutant = bytes;
    const uint64_t limit = round % 2 == 0 ? front : mutant.size();
    for (uint64_t n = 1 + random() % 3; n > 0; --n)
      mutant[random() % limit] ^= static_cast<uint8_t>(1u << random() % 8);
    const Expected<PatchContainer> container = open_container(mutant);
    if (!container) continue;
    ++opened;
    expanded += expand_container(*container, pool).ok() ? 1 : 0;
  }
  EXPECT_GT(opened, 1000u);
  EXPECT_GT(expanded, 10u);
}

}  // namespace
}  // namespace psplit
