// The axes have known places on the octahedral grid, and corrections reach every place from every other.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <random>
#include <set>

#include "src/core/octahedral_chain.h"

namespace psplit::core {
namespace {

constexpr int kBits = 4;
constexpr int32_t kMax = (1 << kBits) - 2, kCenter = kMax / 2;

std::array<float, 3> unit_vector(Vec2 at) {
  std::array<float, 3> out;
  OctahedralGrid(kBits).unit_vector(at, out.data());
  return out;
}

using Place = std::array<int32_t, 2>;
Place project(Vec3 v, bool flip = false) {
  const Vec2 at = OctahedralGrid(kBits).project(v, flip);
  return {at.s, at.t};
}

//    t
//    -x---+z---(-x)      The center of the square is +x, and its four corners are -x.
//     |    |    |
//    -y---+x----+y
//     |    |    |
//    -x---(-z)--(-x)   s
TEST(Octahedral, AxesAreAtTheCenterTheSidesAndTheCorners) {
  using Vector = std::array<float, 3>;
  EXPECT_EQ(unit_vector({kCenter, kCenter}), (Vector{1, 0, 0}));
  EXPECT_EQ(unit_vector({kMax, kCenter}), (Vector{0, 1, 0}));
  EXPECT_EQ(unit_vector({0, kCenter}), (Vector{0, -1, 0}));
  EXPECT_EQ(unit_vector({kCenter, kMax}), (Vector{0, 0, 1}));
  EXPECT_EQ(unit_vector({kCenter, 0}), (Vector{0, 0, -1}));
  for (const Vec2 corner : {Vec2{0, 0}, Vec2{0, kMax}, Vec2{kMax, 0}, Vec2{kMax, kMax}})
    EXPECT_EQ(unit_vector(corner), (Vector{-1, 0, 0}));
}

TEST(Octahedral, ProjectsAxesOfAnyLength) {
  EXPECT_EQ(project({5, 0, 0}), (Place{kCenter, kCenter}));
  EXPECT_EQ(project({0, 1, 0}), (Place{kMax, kCenter}));
  EXPECT_EQ(project({0, 0, -1000}), (Place{kCenter, 0}));
  EXPECT_EQ(project({-1, 0, 0}), (Place{kMax, kMax}));  // one name for all corners
  EXPECT_EQ(project({0, 1, 0}, /*flip=*/true), (Place{0, kCenter}));
  EXPECT_EQ(project({0, 0, 0}), (Place{kCenter, kCenter}));
}

// Every place in the inner diamond is a vector of integers on the octahedron.
TEST(Octahedral, ProjectsPlacesOfTheFrontHalfToThemselves) {
  for (int32_t y = -kCenter; y <= kCenter; ++y)
    for (int32_t z = -kCenter; z <= kCenter; ++z) {
      const int32_t x = kCenter - std::abs(y) - std::abs(z);
      if (x < 0) continue;
      EXPECT_EQ(project({x, y, z}), (Place{y + kCenter, z + kCenter}));
    }
}

// The one name of a place: places on the sides of the square are the same in pairs, and so are its corners.
Place named(Vec2 at) {
  const int32_t y = at.s - kCenter, z = at.t - kCenter, x = kCenter - std::abs(y) - std::abs(z);
  if (x >= 0) return project({x, y, z});
  return project({x, (y < 0 ? -1 : 1) * (kCenter - std::abs(z)), (z < 0 ? -1 : 1) * (kCenter - std::abs(y))});
}

TEST(Octahedral, CorrectionsReachEveryPlaceFromEveryOther) {
  const OctahedralGrid grid(kBits);
  std::set<Place> all;
  for (int32_t s = 0; s <= kMax; ++s)
    for (int32_t t = 0; t <= kMax; ++t) all.insert(named({s, t}));
  EXPECT_EQ(all.size(), static_cast<size_t>((kMax + 1) * (kMax + 1) - 4 * kCenter + 1));
  for (const bool canonicalized : {false, true})
    for (const Place& from : all) {
      const Vec2 same = grid.correct({from[0], from[1]}, {0, 0}, canonicalized);
      EXPECT_EQ(named(same), from);
      std::set<Place> reached;
      for (int32_t a = -kCenter; a <= kCenter; ++a)
        for (int32_t b = -kCenter; b <= kCenter; ++b)
          reached.insert(named(grid.correct({from[0], from[1]}, {a, b}, canonicalized)));
      ASSERT_EQ(reached, all);
    }
}

// Four predicted values that are a quarter turn apart: the same correction leads each of them one step away
// from the center.
TEST(Octahedral, CanonicalizedCorrectionsTurnWithThePredictedValue) {
  const OctahedralGrid grid(kBits);
  const Vec2 from[] = {{-2, -1}, {-1, 2}, {2, 1}, {1, -2}}, to[] = {{-3, -1}, {-1, 3}, {3, 1}, {1, -3}};
  for (int i = 0; i < 4; ++i) {
    const Vec2 at = grid.correct({from[i].s + kCenter, from[i].t + kCenter}, {-1, 0}, /*canonicalized=*/true);
    EXPECT_EQ((Place{at.s, at.t}), (Place{to[i].s + kCenter, to[i].t + kCenter})) << i;
  }
}

// Corrections of all kinds: anywhere, to the sides and the axes of the square, and none.
TEST(OctahedralChain, GoesWhereCorrectLeads) {
  std::mt19937 random(1);
  for (const int bits : {2, 3, 4, 8, 11, 30})
    for (const bool canonicalized : {false, true}) {
      const OctahedralGrid grid(bits);
      const auto center = static_cast<int32_t>(grid.max_quantized() / 2);
      std::uniform_int_distribution<int32_t> anywhere(-2 * center, 2 * center), kind(0, 7);
      const auto any = [&] {
        switch (kind(random)) {
          case 0: return 0;
          case 1: return center;
          case 2: return center + 1;
          case 3: return 1;
          default: return anywhere(random);
        }
      };
      OctahedralChain<int32_t> chain(grid, canonicalized);
      Vec2 last;
      for (int i = 0; i < 20000; ++i) {
        Vec2 at{any(), any()};
        ASSERT_TRUE(is_in_range(grid, at.s) && is_in_range(grid, at.t));
        last = grid.correct(last, at, canonicalized);
        chain.step(at.s, at.t);
        ASSERT_EQ((Place{at.s, at.t}), (Place{last.s, last.t})) << bits << " bits, step " << i;
      }
      EXPECT_FALSE(is_in_range(grid, 2 * center + 1) || is_in_range(grid, -2 * center - 1));
    }
}

#if defined(PSPLIT_HAS_VECTORS)
// Every place of some grids, on the grid and beyond it, where broken streams may lead.
TEST(Octahedral, FourUnitVectorsAtOnceHaveTheBitsOfEach) {
  for (const int bits : {2, 3, 7, 10}) {
    const OctahedralGrid grid(bits);
    const int32_t size = 1 << bits;
    for (int32_t s = -2; s < size + 2; ++s)
      for (int32_t t = -2; t < size + 2; t += 4) {
        const Vec2 at[] = {{s, t}, {s, t + 1}, {s, t + 2}, {s, t + 3}};
        OctahedralGrid::Floats vectors[4];
        grid.unit_vectors({&at[0].s, &at[1].s, &at[2].s, &at[3].s}, vectors);
        for (int k = 0; k < 4; ++k) {
          std::array<float, 3> expected;
          grid.unit_vector(at[k], expected.data());
          ASSERT_EQ(std::memcmp(&vectors[k], expected.data(), sizeof expected), 0)
              << bits << " " << s << " " << t;
        }
      }
  }
}
#endif

}  // namespace
}  // namespace psplit::core
