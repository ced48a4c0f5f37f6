// The smallest streams are ordinary Draco streams of the same meshes, and no larger than libdraco's choices
// make them.
#include "encoder/stream/smallest_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "encoder/coding/quantization.h"
#include "encoder/stream/encode_stream.h"
#include "tests/encoder/stream/random_mesh.h"
#include "tests/encoder/stream/random_soup.h"
#include "tests/src/core/decode_mesh.h"
#include "tests/support/default_codings.h"
#include "tests/support/expect.h"
#include "tests/support/sanitizers.h"

namespace psplit {
namespace {

struct SmallestCounts {
  size_t streams = 0, smaller = 0, refused = 0;
  std::map<core::Scheme, size_t> schemes;
  size_t valence = 0, standard = 0, by_degree = 0, others_by_degree = 0;
};

// libdraco, and the core in its ways, read the same mesh from both streams.
void expect_same_mesh(std::span<const uint8_t> smallest, std::span<const uint8_t> usual) {
  const std::optional<RawMesh> expected = decode_with_libdraco(usual), decoded = decode_with_libdraco(smallest);
  ASSERT_TRUE(expected.has_value());
  ASSERT_TRUE(decoded.has_value());
  EXPECT_TRUE(*decoded == *expected);
  core::StreamHeader header;
  ASSERT_EQ(core::read_stream_header(smallest.data(), smallest.size(), header), core::Fault::kNone);
  RawMesh by_core;
  ASSERT_EQ(core::decode<uint32_t>(header, by_core), core::Fault::kNone);
  EXPECT_TRUE(by_core == *expected);
  ASSERT_EQ(core::decode_in_workspace<uint32_t>(header, smallest.size(), *expected, by_core),
            core::Fault::kNone);
  EXPECT_TRUE(by_core == *expected);
  constexpr uint32_t kMostPointsOfWarp = 2000;  // the emulated warp is slow
  if (expected->point_count > kMostPointsOfWarp) return;
  ASSERT_EQ(core::decode<uint16_t>(header, by_core), core::Fault::kNone);
  EXPECT_TRUE(by_core == *expected);
  ASSERT_EQ(core::decode_by_warp<uint16_t>(header, {LaneOrder::kShuffled, 1}, by_core), core::Fault::kNone);
  EXPECT_TRUE(by_core == *expected);
}

// What the stream chose.
void count_choices(std::span<const uint8_t> bytes, SmallestCounts& counts) {
  const DracoFields fields = must(read_fields(bytes));
  EXPECT_NE(fields.possible_levels, 0u);  // it comes back from its fields, so it may be condensed
  constexpr size_t kConnectivityAt = 11, kGroupsAt = 13, kGroupBytes = 3;
  ++(fields.skeleton[kConnectivityAt] == 0 ? counts.standard : counts.valence);
  for (const AttributeFields& attribute : fields.attributes) ++counts.schemes[attribute.skeleton.scheme];
  for (size_t group = 0; group < fields.skeleton[kGroupsAt]; ++group)
    if (fields.skeleton[kGroupsAt + kGroupBytes * group + kGroupBytes] == 1)
      ++(group == 0 ? counts.by_degree : counts.others_by_degree);
}

// A stream that is to be condensed allows its positions to be coded in order of creation.
void expect_created_positions(const WeldedMesh& welded, const PatchMesh& patch,
                              const std::vector<AttributeCoding>& codings, size_t fewest,
                              std::span<const uint8_t> usual) {
  const EncodedPatch created = must(encode_smallest_stream(welded, patch, codings, false, true));
  EXPECT_GE(created.bytes.size(), fewest);
  EXPECT_LE(created.bytes.size(), usual.size());
  EXPECT_TRUE(decode_with_libdraco(created.bytes) == decode_with_libdraco(usual));
  const core::SkeletonAttribute positions = must(read_fields(created.bytes)).attributes[0].skeleton;
  EXPECT_TRUE(positions.is_raw() || positions.allows_creation_order());
}

void expect_smallest(const WeldedMesh& welded, const PatchMesh& patch,
                     const std::vector<AttributeCoding>& codings, SmallestCounts& counts) {
  const Expected<EncodedPatch> usual = encode_stream(welded, patch, codings, 5, true);
  const Expected<EncodedPatch> smallest = encode_smallest_stream(welded, patch, codings, true);
  if (!usual) {
    // Values that libdraco's choice of schemes cannot code may be coded without prediction.
    ++counts.refused;
    return;
  }
  ASSERT_TRUE(smallest.ok()) << smallest.status().to_string();
  EXPECT_LE(smallest->bytes.size(), usual->bytes.size());
  for (int speed = 0; speed < 5; ++speed)
    if (const Expected<EncodedPatch> other = encode_stream(welded, patch, codings, speed)) {
      EXPECT_LE(smallest->bytes.size(), other->bytes.size()) << "speed " << speed;
    }
  EXPECT_EQ(smallest->patch_point, usual->patch_point);
  EXPECT_EQ(smallest->decoded.faces, usual->decoded.faces);
  for (size_t i = 0; i < usual->decoded.attributes.size(); ++i)
    EXPECT_EQ(smallest->decoded.attributes[i].values, usual->decoded.attributes[i].values);
  expect_same_mesh(smallest->bytes, usual->bytes);
  count_choices(smallest->bytes, counts);
  expect_created_positions(welded, patch, codings, smallest->bytes.size(), usual->bytes);
  ++counts.streams;
  if (smallest->bytes.size() < usual->bytes.size()) ++counts.smaller;
}

void expect_smallest(const Mesh& mesh, const std::vector<AttributeCoding>& codings, SmallestCounts& counts) {
  WeldedMesh welded = weld(mesh, ThreadPool(1));
  separate_flat_faces(welded);
  expect_smallest(welded, whole_mesh(mesh), codings, counts);
}

TEST(SmallestStream, OfEveryMeshIsNoLargerAndDecodesTheSame) {
  SmallestCounts counts;
  for (const NamedMesh& named : all_meshes()) {
    if (named.mesh.faces.empty()) continue;
    for (const bool lossless : {false, true}) {
      SCOPED_TRACE(named.name + (lossless ? ", lossless" : ""));
      expect_smallest(named.mesh, default_codings(named.mesh, lossless).codings, counts);
      if (testing::Test::HasFailure()) return;
    }
  }
  EXPECT_GT(counts.streams, 50u);
  EXPECT_GT(counts.standard, 0u);
  EXPECT_GT(counts.valence, 0u);
  EXPECT_GT(8 * counts.smaller, counts.streams);
  RecordProperty("streams", static_cast<int>(counts.streams));
  RecordProperty("smaller", static_cast<int>(counts.smaller));
}

TEST(SmallestStream, OfRandomAttributesMakesEveryChoice) {
  SmallestCounts counts;
  for (uint32_t seed = 0; seed < random_rounds(1500); ++seed) {
    std::mt19937 random(seed);
    const RandomMesh made = random_mesh(random);
    SCOPED_TRACE("seed " + std::to_string(seed));
    expect_smallest(made.mesh, made.codings, counts);
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GT(counts.streams, random_rounds(1000));
  EXPECT_GT(8 * counts.smaller, counts.streams);
  using enum core::Scheme;
  constexpr bool kAllSeeds = !kHasSanitizers;  // a tenth lacks the rarest choice
  for (const core::Scheme scheme :
       {kNone, kDifference, kParallelogram, kConstrainedMultiParallelogram, kTexCoords, kGeometricNormal})
    if (kAllSeeds || scheme != kConstrainedMultiParallelogram) {
      EXPECT_GT(counts.schemes[scheme], 0u) << static_cast<int>(scheme);
    }
  for (const size_t count : {counts.by_degree, counts.others_by_degree}) EXPECT_GT(count, 0u);
  RecordProperty("streams", static_cast<int>(counts.streams));
  RecordProperty("smaller", static_cast<int>(counts.smaller));
}

TEST(SmallestStream, OfRandomFacesDecodesTheSame) {
  SmallestCounts counts;
  const size_t count = random_rounds(1000);
  for (size_t seed = 0; seed < count; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Soup soup;
    SoupMaker(seed).make(seed % 40 == 0 ? 5000 : seed % 4 == 0 ? 300 : 30, soup);
    expect_smallest(soup.welded, soup.patch, default_codings(soup.mesh, false).codings, counts);
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GT(counts.streams, count / 2);
}

// Products of long edges on fine grids overflow; no decoder must meet them.
TEST(SmallestStream, OfLongEdgesDecodesTheSame) {
  SmallestCounts counts;
  const Mesh mesh = long_edges();
  for (const int bits : {8, 17, 20, 21, 22})
    for (const int texture_bits : {12, 21, 23}) {
      SCOPED_TRACE(std::to_string(bits) + ", " + std::to_string(texture_bits) + " bits");
      std::vector<AttributeCoding> codings = default_codings(mesh, false).codings;
      for (size_t i = 0; i < codings.size(); ++i) {
        const bool is_texture = mesh.attributes[i].semantic.starts_with("TEXCOORD");
        if (is_texture || mesh.attributes[i].semantic == "POSITION")
          codings[i] = must(fit_grid(mesh.attributes[i], is_texture ? texture_bits : bits));
      }
      expect_smallest(mesh, codings, counts);
    }
  EXPECT_EQ(counts.streams, 15u);
}

}  // namespace
}  // namespace psplit
