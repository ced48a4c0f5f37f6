// Containers of condensed streams from encode_mesh: they hold what Draco streams hold, and any change of their
// front is an error or another container.

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

// A grid in several patches, all of them condensed.
EncodedMesh condensed_grid() {
  const EncodeOptions options{.patch_count = 9, .condense = true};
  EncodedMesh encoded = std::move(*encode(make_grid(60, 60), options));
  EXPECT_EQ(open_container(encoded.container)->condensed_count(), 9u);
  return encoded;
}

TEST(EncodeCondensed, ExpandsToThePlainContainer) {
  const ThreadPool pool(2);
  size_t condensed_count = 0;
  uint32_t round = 0;
  for (const NamedMesh& named : all_meshes())
    for (const bool lossless : {false, true}) {
      SCOPED_TRACE(named.name);
      EncodeOptions options{.patch_count = 1 + round++ % 7, .encode_speed = static_cast<int>(round * 3 % 11)};
      const Expected<EncodedMesh> plain = encode(named.mesh, options, lossless);
      options.condense = true;
      options.condense_smallest = round % 2 == 0;
      const Expected<EncodedMesh> condensed = encode(named.mesh, options, lossless);
      ASSERT_TRUE(plain && condensed) << plain.status().to_string() << condensed.status().to_string();
      const PatchContainer plain_container = *open_container(plain->container);
      const PatchContainer container = *open_container(condensed->container);
      if (container.condensed_count() == 0) {
        EXPECT_EQ(condensed->container, plain->container);
        continue;
      }
      ++condensed_count;
      EXPECT_LT(condensed->container.size(), plain->container.size());
      const auto expanded = must(expand_container(container, pool));
      EXPECT_EQ(expanded, plain->container);
      EXPECT_EQ(condensed->source_point, plain->source_point);
      EXPECT_TRUE(same_bits(condensed->decoded, plain->decoded));
      for (uint32_t i = 0; i < container.entries.size(); ++i) {
        const PatchContainer alone = container.alone(i);
        const Mesh patch = must(draco_backend().decode(alone, condensed->requests, pool));
        EXPECT_TRUE(
            same_bits(patch, *draco_backend().decode(plain_container.alone(i), condensed->requests, pool)));
      }
    }
  EXPECT_GT(condensed_count, 10u);
}

TEST(EncodeCondensed, ThreadsDoNotChangeTheBytes) {
  const EncodeOptions options{.patch_count = 9, .condense = true};
  const Mesh mesh = make_grid(60, 60);
  EXPECT_EQ(encode(mesh, options, false, 1)->container, encode(mesh, options, false, 5)->container);
}

// A single stream needs no container, so it is condensed only if that is smaller than the stream alone.
TEST(EncodeCondensed, ASmallMeshStaysAsItIs) {
  const EncodeOptions options{.condense = true};
  const EncodedMesh encoded = must(encode(make_grid(2, 2), options));
  EXPECT_EQ(open_container(encoded.container)->condensed_count(), 0u);
}

TEST(EncodeCondensed, RefusesEveryTruncation) {
  const std::vector<uint8_t> bytes = condensed_grid().container;
  for (size_t length = 0; length < bytes.size(); ++length) {
    const std::vector<uint8_t> part(bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(length));
    EXPECT_FALSE(open_container(part).ok()) << length;
  }
}

// The residue is never condensed, so its row does not say whether it is.
TEST(EncodeCondensed, RefusesACondensedStreamAsTheResidue) {
  std::vector<uint8_t> bytes = condensed_grid().container;
  bytes[5] = 1;
  EXPECT_EQ(open_container(bytes).status().code(), StatusCode::kInvalidInput);
}

TEST(EncodeCondensed, RefusesAHeadWithoutCondensedStreams) {
  const EncodedMesh encoded = condensed_grid();
  const PatchContainer condensed = *open_container(encoded.container);
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
  const std::vector<uint8_t> with_head = write_container(entries, false, stitch, streams, head);
  EXPECT_EQ(open_container(with_head).status().message(),
            "container: tables of condensed streams, but no condensed stream");
  EXPECT_EQ(open_container(write_container(condensed.entries, false, stitch, streams)).status().message(),
            "container: the directory counts more skeletons than the head has");
}

// Mutants of all bytes: an error with its place, or another container. Whatever opens can be expanded or says
// why not, and takes memory in proportion to its bytes.
TEST(EncodeCondensed, MutantsAreErrorsOrOtherContainers) {
  const std::vector<uint8_t> bytes = condensed_grid().container;
  const uint64_t front = open_container(bytes)->header_bytes;
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
