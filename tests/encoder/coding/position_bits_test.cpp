// Bits of positions, from edges and from a bound on the error.
#include "encoder/coding/position_bits.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "encoder/coding/quantization.h"
#include "encoder/encode_mesh.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

AttributeCoding grid(float range, float origin = 0) {
  return {kMostGridBits, false, {origin, origin, origin}, range};
}

std::vector<float> sorted(std::vector<float> lengths) {
  std::sort(lengths.begin(), lengths.end());
  return lengths;
}

// A sheet whose points are moved at random: on it, all floats of a range occur.
Mesh scattered(float origin, float range, uint32_t seed) {
  Mesh mesh = make_grid(20, 20);
  std::mt19937 random(seed);
  std::vector<float> values(size_t{3} * mesh.point_count);
  for (float& value : values) value = origin + range * static_cast<float>(random()) / 4294967296.0f;
  std::memcpy(mesh.attributes[0].values.data(), values.data(), values.size() * sizeof(float));
  return mesh;
}

TEST(EdgeSample, HasAllEdgesOfASmallMesh) {
  EdgeSample sample;
  sample.add(make_grid(3, 2));
  EXPECT_EQ(sample.lengths().size(), 36u);
  EXPECT_EQ(std::ranges::count(sample.lengths(), 1.0f), 24);
}

TEST(EdgeSample, IsBoundedAndTheSameInAnyOrder) {
  const Mesh mesh = make_grid(100, 50);
  constexpr size_t kMost = 400;
  EdgeSample whole(kMost), reversed(kMost);
  whole.add(mesh);
  EXPECT_LE(whole.lengths().size(), 3 * kMost);
  EXPECT_GE(whole.lengths().size(), 3 * kMost / 4);
  size_t wanted = 0;
  for (size_t f = mesh.faces.size(); f-- > 0;) {
    if (!reversed.wants(f)) continue;
    ++wanted;
    std::array<std::array<float, 3>, 3> corners;
    for (size_t i = 0; i < 3; ++i)
      std::memcpy(corners[i].data(), mesh.attributes[0].values.data() + mesh.faces[f][i] * 12, 12);
    reversed.add(f, corners);
  }
  EXPECT_LT(wanted, mesh.faces.size() / 2);
  EXPECT_EQ(sorted(whole.lengths()), sorted(reversed.lengths()));
}

TEST(EdgeSample, LeavesOutEdgesOfNoLength) {
  EdgeSample sample;
  sample.add(0, {{{0, 0, 0}, {0, 0, 0}, {3, 4, 0}}});
  EXPECT_EQ(sample.lengths(), (std::vector<float>{5, 5}));
}

TEST(StepForEdges, IsATwentiethOfAShortEdge) {
  std::vector<float> lengths(100, 8.0f);
  EXPECT_DOUBLE_EQ(step_for_edges(lengths), 0.4);
  std::fill_n(lengths.begin(), 5, 0.001f);  // 5 % may be shorter
  EXPECT_DOUBLE_EQ(step_for_edges(lengths), 0.4);
  std::fill_n(lengths.begin(), 6, 2.0f);
  EXPECT_DOUBLE_EQ(step_for_edges(lengths), 0.1);
  EXPECT_EQ(step_for_edges({}), 0);
}

TEST(PositionBitsForStep, AreTheFewestThatReachTheStep) {
  for (int bits = kLeastBitsForEdges + 1; bits <= 23; ++bits) {
    AttributeCoding coding = grid(7.0f, -3.0f);
    const double step = 7.0 / (std::ldexp(1.0, bits) - 1);
    EXPECT_EQ(position_bits_for_step(coding, step), bits);
    EXPECT_EQ(position_bits_for_step(coding, step * 0.999), bits + 1);
  }
}

TEST(PositionBitsForStep, AreWithinLimits) {
  EXPECT_EQ(position_bits_for_step(grid(1), 1e-1), kLeastBitsForEdges);
  EXPECT_EQ(position_bits_for_step(grid(1), 0), kLeastBitsForEdges);
  // Floats from 0 to 1 are 2^-24 apart below 1: finer steps hold nothing more.
  EXPECT_EQ(position_bits_for_step(grid(1), 1e-12), 25);
  // Near 1000 they are 2^-14 apart, half of which is 2^-15.
  EXPECT_LE(position_bits_for_step(grid(1, 1000), 1e-12), 15);
}

TEST(PositionBitsForError, AreTheFewestWhoseBoundHolds) {
  for (const double error : {0.3, 1e-2, 1e-4, 1e-5, 2e-6}) {
    AttributeCoding coding = grid(2, -1);
    const Expected<int> bits = position_bits_for_error(coding, error);
    ASSERT_TRUE(bits.ok()) << error << bits.status().to_string();
    coding.bits = *bits;
    EXPECT_LE(distance_bound(coding), error);
    coding.bits = *bits - 1;
    EXPECT_TRUE(coding.bits == 0 || distance_bound(coding) > error);
  }
}

TEST(PositionBitsForError, RefuseWhatFloatsCannotHold) {
  const Expected<int> bits = position_bits_for_error(grid(100, 500000), 0.001);
  ASSERT_FALSE(bits.ok());
  EXPECT_EQ(bits.status().code(), StatusCode::kUsage);
  EXPECT_TRUE(contains(bits.status().message(), "--lossless"));
  EXPECT_TRUE(position_bits_for_error(grid(100, 500000), 0.1).ok());
}

// What libdraco makes of the grid, for ranges and places at which floats are fine and coarse.
TEST(DistanceBound, HoldsForDecodedPositions) {
  const ThreadPool pool(1);
  for (const auto& [origin, range] :
       {std::pair{0.0f, 1.0f}, {-1.0f, 2.0f}, {1000.0f, 1.0f}, {-3e5f, 40.0f}, {1e-6f, 1e-3f}, {0.1f, 1e6f}})
    for (const int bits : {4, 11, 14, 16, 18, 20, 21, 22, 23, 24}) {
      const Mesh mesh = scattered(origin, range, static_cast<uint32_t>(bits));
      const std::vector<AttributeCoding> codings{*fit_grid(mesh.attributes[0], bits)};
      const auto encoded = must(encode_mesh(mesh, codings, {}, pool));
      const double bound = distance_bound(codings[0]);
      const std::optional<double>& error = encoded.statistics.position_error;
      ASSERT_TRUE(error.has_value());
      EXPECT_LE(*error, bound) << origin << " " << range << " " << bits;
      // The bound is not idle. If floats are coarser than the grid, positions may be exact.
      const bool is_fine = std::fabs(origin) <= range && bits <= 22;
      EXPECT_TRUE(!is_fine || *error > bound / 8) << origin << " " << range << " " << bits;
    }
}

TEST(DistanceBound, IsNotMeasuredWithoutVerification) {
  const Mesh mesh = make_grid(4, 4);
  const StreamOptions options{.verify = false};
  const auto encoded = must(encode_mesh(mesh, std::vector<AttributeCoding>{*fit_grid(mesh.attributes[0], 14)},
                                        options, ThreadPool(1)));
  EXPECT_FALSE(encoded.statistics.position_error.has_value());
}

}  // namespace
}  // namespace psplit
