// Plans, skeletons and integers of attributes equal libdraco's: the values of a mesh and the connectivity of
// its stream give the bytes of libdraco's stream.
#include "encoder/stream/encode_attributes.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "encoder/coding/position_bits.h"
#include "encoder/coding/quantization.h"
#include "encoder/libdraco/patch_stream.h"
#include "encoder/stream/patch_steps.h"
#include "encoder/stream/sequential_stream.h"
#include "tests/encoder/stream/decoded_values.h"
#include "tests/encoder/stream/random_mesh.h"
#include "tests/support/default_codings.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/reproducible_meshes.h"
#include "tests/support/sanitizers.h"

namespace psplit {
namespace {

constexpr size_t kTraversalAt = 11;  // in a skeleton
constexpr uint8_t kValence = 2;

// The fields of a stream, with the attributes' part made from the mesh.
DracoFields make_fields(const DracoFields& stored, const WeldedMesh& welded, const PatchMesh& patch,
                        std::span<const AttributeCoding> codings, int speed, const EncodedPatch& encoded) {
  DecodedValues decoded;
  must(decoded.decode(encoded.bytes) == core::Fault::kNone ? Status() : runtime_failure("not decoded"));
  const core::Patch<uint32_t>& tables = decoded.patch();
  std::vector<uint32_t> point_of_corner(tables.point_at.size());
  for (uint32_t corner = 0; corner < point_of_corner.size(); ++corner)
    if (corner % 4 != 3) point_of_corner[corner] = encoded.patch_point[tables.point_at[corner]];
  const auto overflows = [&](size_t i) { return texture_prediction_may_overflow(welded, patch, codings, i); };
  EncodedAttributes attributes =
      must(encode_attributes({welded, codings, patch.points_of_values()},
                             {.speed = speed, .point_count = static_cast<uint32_t>(patch.points.size())},
                             overflows, {tables.groups.data(), tables.groups.size()}, point_of_corner));
  std::vector<uint8_t> has_seams;
  for (const std::vector<uint8_t>& seams : stored.seams)
    has_seams.push_back(std::ranges::count(seams, 1) > 0 ? 1 : 0);
  DracoFields made = stored;
  made.attributes = std::move(attributes.fields);
  made.skeleton = edgebreaker_skeleton(attributes.plans, stored.skeleton[kTraversalAt] == kValence, has_seams);
  made.symbol_level = symbol_level_of(speed);
  return made;
}

struct StreamCounts {
  size_t streams = 0;
  // A libdraco that fuses multiply-adds rounds a few values to the step beside ours.
  size_t rounded = 0;

  void expect_more_than(size_t least) const {
    EXPECT_GT(streams, least);
    EXPECT_LE(rounded * 100, streams);
    testing::Test::RecordProperty("streams", std::to_string(streams));
  }
};

// Counts the stream, if libdraco has one of the mesh.
void expect_same_stream(const std::string& name, const Mesh& mesh, std::span<const AttributeCoding> codings,
                        int speed, StreamCounts& counts) {
  SCOPED_TRACE(name + ", speed " + std::to_string(speed));
  WeldedMesh welded = weld(mesh, ThreadPool(1));
  separate_flat_faces(welded);
  const PatchMesh whole = whole_mesh(mesh);
  const Expected<EncodedPatch> encoded = encode_edgebreaker(welded, whole, codings, speed);
  if (!encoded) return;
  ++counts.streams;
  const DracoFields stored = must(read_fields(encoded->bytes));
  const DracoFields made = make_fields(stored, welded, whole, codings, speed, *encoded);
  const std::vector<uint8_t> bytes = must(write_fields(made));
  if (kLibdracoFuses && bytes != encoded->bytes) {
    ++counts.rounded;
    return;
  }
  EXPECT_EQ(made.skeleton, stored.skeleton);
  for (size_t i = 0; i < stored.attributes.size(); ++i) {
    EXPECT_EQ(made.attributes[i].symbols, stored.attributes[i].symbols) << "attribute " << i;
    EXPECT_EQ(made.attributes[i].raw, stored.attributes[i].raw) << "attribute " << i;
  }
  EXPECT_EQ(bytes, encoded->bytes);
}

std::vector<AttributeCoding> codings_of_bits(const Mesh& mesh, int bits) {
  std::vector<AttributeCoding> codings;
  for (const Attribute& attribute : mesh.attributes) {
    AttributeCoding coding;
    if (attribute.component_type == ComponentType::kFloat32) {
      if (attribute.semantic == "NORMAL" && bits > 1)
        coding = {bits, true, {}, 0};
      else if (Expected<AttributeCoding> grid = fit_grid(attribute, bits))
        coding = std::move(*grid);
    }
    codings.push_back(std::move(coding));
  }
  return codings;
}

TEST(EncodeAttributes, EveryMeshAtEverySpeedHasTheBytesOfLibdraco) {
  StreamCounts counts;
  for (const NamedMesh& named : all_meshes())
    for (const bool lossless : {false, true}) {
      const Coded coded = default_codings(named.mesh, lossless);
      for (int speed = 0; speed <= 10; ++speed)
        expect_same_stream(named.name + (lossless ? ", lossless" : ""), named.mesh, coded.codings, speed,
                           counts);
    }
  counts.expect_more_than(300u);
}

// libdraco's encoder counts symbols in tables that have an entry for every number up to the largest. So grids
// of many bits are larger than the mesh, which has the numbers of kMostWidth bits.
std::vector<AttributeCoding> codings_of_large_grids(const Mesh& mesh, int bits) {
  constexpr int kMostWidth = 18;
  std::vector<AttributeCoding> codings = codings_of_bits(mesh, bits);
  for (AttributeCoding& coding : codings)
    if (coding.octahedral)
      coding.bits = std::min(bits, kMostWidth);
    else if (bits > kMostWidth)
      coding.range = std::ldexp(coding.range, bits - kMostWidth);
  return codings;
}

TEST(EncodeAttributes, EveryNumberOfBitsHasTheBytesOfLibdraco) {
  StreamCounts counts;
  const Mesh sheet = make_sheet(24, 20), edges = long_edges();
  for (int bits = 1; bits <= kMostGridBits; ++bits)
    for (const int speed : {0, 3, 5, 8})
      for (const Mesh* mesh : {&sheet, &edges})
        expect_same_stream("bits " + std::to_string(bits), *mesh, codings_of_large_grids(*mesh, bits), speed,
                           counts);
  counts.expect_more_than(200u);
}

TEST(EncodeAttributes, RandomMeshesHaveTheBytesOfLibdraco) {
  StreamCounts counts;
  for (uint32_t seed = 0; seed < random_rounds(3000); ++seed) {
    std::mt19937 random(seed);
    const RandomMesh made = random_mesh(random);
    const int speed = seed % 2 == 0 ? static_cast<int>(seed / 2 % 4) : static_cast<int>(seed / 2 % 11);
    expect_same_stream("seed " + std::to_string(seed), made.mesh, made.codings, speed, counts);
    ASSERT_FALSE(HasFailure()) << "seed " << seed;
  }
  counts.expect_more_than(random_rounds(2000));
}

// libdraco's encoder takes integers as signed numbers of 32 bits, and refuses others.
TEST(EncodeAttributes, LargeIntegersAreRefusedAsByLibdraco) {
  for (const uint32_t largest : {0x7ffffffeu, 0x80000000u}) {
    Mesh mesh = make_grid(3, 3);
    std::vector<uint32_t> ids(mesh.point_count, 5);
    ids[4] = largest;
    mesh.attributes.push_back(make_attribute("_ID", ComponentType::kUint32, 1, false, ids));
    std::vector<AttributeCoding> codings = codings_of_bits(mesh, 8);
    std::vector<uint32_t> points(mesh.point_count);
    std::iota(points.begin(), points.end(), 0u);
    const WeldedMesh welded = weld(mesh, ThreadPool(1));
    const auto made = write_sequential_stream({welded, codings, points}, mesh.faces, 10);
    const auto expected = encode_sequential(welded, whole_mesh(mesh), codings, 10);
    EXPECT_EQ(made.status().ok(), largest < 0x80000000u);
    EXPECT_EQ(expected.status().ok(), largest < 0x80000000u);
  }
}

// libdraco stores the first of the least values, so the first zero decides the sign of the grid's origin.
TEST(EncodeAttributes, TheOriginIsTheFirstZero) {
  StreamCounts counts;
  for (const float first : {0.0f, -0.0f}) {
    std::vector<float> positions;
    for (int i = 0; i < 9; ++i)
      positions.insert(positions.end(),
                       {i % 3 == 0 ? (i == 0 ? first : -first) : static_cast<float>(i % 3),
                        static_cast<float>(i / 3), -static_cast<float>(i / 3 == 0 ? 0 : i / 3)});
    const Mesh mesh = make_mesh(positions, make_grid(2, 2).faces);
    for (const int speed : {0, 5, 7})
      expect_same_stream("zeros", mesh, codings_of_bits(mesh, 10), speed, counts);
  }
  EXPECT_EQ(counts.streams, 6u);
}

}  // namespace
}  // namespace psplit
