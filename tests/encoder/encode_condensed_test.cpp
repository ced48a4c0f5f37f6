// Containers of condensed streams from encode_mesh: they hold what Draco streams hold.

#include "encoder/encode_mesh.h"
#include "encoder/fields/expand_container.h"
#include "psplit/encode.h"
#include "src/container/condensed_head.h"
#include "tests/support/decode_bytes.h"
#include "tests/support/default_codings.h"
#include "tests/support/patched_samples.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/same_bits.h"

namespace psplit {
namespace {

Expected<EncodedMesh> encode(const Mesh& mesh, const StreamOptions& options, bool lossless = false) {
  return encode_mesh(mesh, default_codings(mesh, lossless).codings, options, ThreadPool(2));
}

// A grid in several patches, all of them condensed.
EncodedMesh condensed_grid() {
  const StreamOptions options{.patch_count = 9, .condense = true};
  EncodedMesh encoded = std::move(*encode(make_grid(60, 60), options));
  EXPECT_EQ(open_container(encoded.pieces[0].bytes)->condensed_count(), 9u);
  return encoded;
}

TEST(EncodeCondensed, ExpandsToThePlainContainer) {
  const ThreadPool pool(2);
  size_t condensed_count = 0, kept_count = 0;
  uint32_t round = 0;
  for (const NamedMesh& named : all_meshes())
    for (const bool lossless : {false, true}) {
      SCOPED_TRACE(named.name);
      StreamOptions options{.patch_count = 1 + round++ % 7, .encode_speed = static_cast<int>(round * 3 % 11)};
      const Expected<EncodedMesh> plain = encode(named.mesh, options, lossless);
      options.condense = true;
      options.condense_smallest = round % 2 == 0;
      const Expected<EncodedMesh> condensed = encode(named.mesh, options, lossless);
      ASSERT_TRUE(plain && condensed) << plain.status().to_string() << condensed.status().to_string();
      const PatchContainer plain_container = *open_container(plain->pieces[0].bytes);
      const PatchContainer container = *open_container(condensed->pieces[0].bytes);
      if (container.condensed_count() == 0) {
        EXPECT_EQ(condensed->pieces[0].bytes, plain->pieces[0].bytes);
        ++kept_count;
        continue;
      }
      ++condensed_count;
      EXPECT_LT(condensed->pieces[0].bytes.size(), plain->pieces[0].bytes.size());
      const auto expanded = must(expand_container(container, pool));
      EXPECT_EQ(expanded, plain->pieces[0].bytes);
      EXPECT_EQ(condensed->pieces[0].source_point, plain->pieces[0].source_point);
      EXPECT_TRUE(same_bits(condensed->pieces[0].decoded, plain->pieces[0].decoded));
      for (uint32_t i = 0; i < container.entries.size(); ++i) {
        const PatchContainer alone = container.alone(i);
        const Mesh patch = must(draco_backend().decode(alone, condensed->requests, pool));
        EXPECT_TRUE(
            same_bits(patch, *draco_backend().decode(plain_container.alone(i), condensed->requests, pool)));
      }
    }
  EXPECT_GT(condensed_count, 10u);
  EXPECT_GT(kept_count, 0u);  // tables of small meshes take more than they save
}

// The residue is never condensed, so its row does not say whether it is.
TEST(EncodeCondensed, RefusesACondensedStreamAsTheResidue) {
  std::vector<uint8_t> bytes = condensed_grid().pieces[0].bytes;
  bytes[5] = 1;
  EXPECT_EQ(open_container(bytes).status().code(), StatusCode::kInvalidInput);
}

TEST(EncodeCondensed, RefusesAHeadWithoutCondensedStreams) {
  const EncodedMesh encoded = condensed_grid();
  const PatchContainer condensed = *open_container(encoded.pieces[0].bytes);
  ContainerParts parts(condensed);
  for (uint32_t i = 0; i < parts.entries.size(); ++i) {
    parts.streams[i] = *expand_patch(condensed, i);
    parts.entries[i].is_condensed = false;
  }
  EXPECT_EQ(open_container(parts.write()).status().message(),
            "container: tables of condensed streams, but no condensed stream");
  parts.head.clear();
  parts.entries = condensed.entries;
  EXPECT_EQ(open_container(parts.write()).status().message(),
            "container: the directory counts more skeletons than the head has");
}

}  // namespace
}  // namespace psplit
