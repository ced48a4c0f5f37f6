// Which triangles find a partner, compared with an exhaustive search and on difficult values.
#include "gltf_ext/compare/match_elements.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>

#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

using Random = std::mt19937;

std::vector<float> positions_of(const Mesh& mesh) {
  std::vector<float> values(mesh.point_count * size_t{3});
  std::memcpy(values.data(), mesh.attributes[0].values.data(), values.size() * sizeof(float));
  return values;
}

ElementBag bag_of(const Mesh& mesh, const std::vector<double>& within, int corner_count = 3) {
  ElementBag bag(corner_count);
  ElementPart part{mesh.faces, {}, {}};
  for (size_t i = 0; i < mesh.attributes.size(); ++i) {
    part.columns.push_back(&mesh.attributes[i]);
    part.limits.push_back({within[i], -1});
  }
  bag.add(std::move(part));
  return bag;
}

// The limits are those of `b`.
ElementMatch match(const Mesh& a, const Mesh& b, const std::vector<double>& within) {
  const ElementBag bag_a = bag_of(a, std::vector<double>(within.size(), 0.0)), bag_b = bag_of(b, within);
  const Expected<ElementMatch> found =
      match_elements(ElementPair(bag_a, bag_b, std::vector<bool>(within.size(), false)), TearSearch::kInB);
  EXPECT_TRUE(found) << found.status().to_string();
  return found ? *found : ElementMatch{};
}

size_t pairs(const ElementMatch& match) {
  return match.partner.size() - static_cast<size_t>(std::ranges::count(match.partner, kNoElement));
}

// Each corner gets its own point, and points and triangles come in another order.
Mesh shuffled(const Mesh& mesh, Random& random) {
  std::vector<uint32_t> order(mesh.faces.size()), number(3 * mesh.faces.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::shuffle(order, random);
  std::iota(number.begin(), number.end(), 0u);
  std::ranges::shuffle(number, random);
  Mesh result;
  result.point_count = static_cast<uint32_t>(number.size());
  for (const Attribute& attribute : mesh.attributes) {
    result.attributes.push_back(attribute);
    result.attributes.back().values.resize(number.size() * attribute.stride());
  }
  for (const uint32_t face : order) {
    const size_t turn = random() % 3;
    std::array<uint32_t, 3>& points = result.faces.emplace_back();
    for (size_t corner = 0; corner < 3; ++corner) {
      const uint32_t from = mesh.faces[face][(corner + turn) % 3];
      const uint32_t to = points[corner] = number[3 * (result.faces.size() - 1) + corner];
      for (size_t i = 0; i < mesh.attributes.size(); ++i) {
        const size_t stride = mesh.attributes[i].stride();
        std::memcpy(result.attributes[i].values.data() + to * stride,
                    mesh.attributes[i].values.data() + from * stride, stride);
      }
    }
  }
  return result;
}

// Rounds each float to a multiple of `step`. Halves go up or down, equal values in the same direction.
void quantize(Mesh& mesh, double step, unsigned seed) {
  std::vector<float> values = positions_of(mesh);
  for (float& value : values) {
    const double steps = static_cast<double>(value) / step, low = std::floor(steps);
    const bool up =
        steps - low == 0.5 ? Random(seed + std::bit_cast<uint32_t>(value))() % 2 == 0 : steps - low > 0.5;
    value = static_cast<float>((low + (up ? 1 : 0)) * step);
  }
  std::memcpy(mesh.attributes[0].values.data(), values.data(), values.size() * sizeof(float));
}

TEST(MatchElements, OrderCornersAndSplitPointsDoNotCount) {
  Random random(1);
  for (const NamedMesh& named : procedural_meshes()) {
    const std::vector<double> exact(named.mesh.attributes.size(), 0.0);
    const ElementMatch found = match(named.mesh, shuffled(named.mesh, random), exact);
    EXPECT_EQ(pairs(found), named.mesh.faces.size()) << named.name;
    EXPECT_FALSE(found.tear) << named.name;
  }
}

TEST(MatchElements, AnyGridOfPositionsIsWithinHalfAStep) {
  Random random(2);
  for (const NamedMesh& named : procedural_meshes())
    for (const int bits : {3, 5, 8, 14, 20}) {
      Mesh quantized = named.mesh;
      const double step = std::ldexp(2.0, -bits);
      quantize(quantized, step, 7);
      std::vector<double> within(named.mesh.attributes.size(), 0.0);
      within[0] = step / 2 + 1e-6;
      const ElementMatch found = match(named.mesh, shuffled(quantized, random), within);
      EXPECT_EQ(pairs(found), named.mesh.faces.size()) << named.name << ", " << bits << " bits";
      EXPECT_LE(found.largest[0], within[0]);
      EXPECT_FALSE(found.tear) << named.name << ", " << bits << " bits";
    }
}

TEST(MatchElements, PointsOnBordersOfTheGridMayGoToEitherSide) {
  // Every coordinate is halfway between two steps.
  Random random(3);
  Mesh mesh = make_grid(40, 30);
  std::vector<float> values = positions_of(mesh);
  for (float& value : values) value = value * 4 + 0.5f;
  std::memcpy(mesh.attributes[0].values.data(), values.data(), values.size() * sizeof(float));
  Mesh quantized = mesh;
  quantize(quantized, 1.0, 8);
  EXPECT_EQ(pairs(match(mesh, shuffled(quantized, random), {0.5})), mesh.faces.size());
  EXPECT_LT(pairs(match(mesh, shuffled(quantized, random), {0.499})), mesh.faces.size());
}

TEST(MatchElements, AMirroredTriangleHasNoPartner) {
  Random random(4);
  const Mesh mesh = make_grid(9, 7);
  Mesh other = mesh;
  std::swap(other.faces[50][1], other.faces[50][2]);
  const ElementMatch found = match(mesh, shuffled(other, random), {0.1});
  EXPECT_EQ(pairs(found), mesh.faces.size() - 1);
  EXPECT_EQ(found.partner[50], kNoElement);
}

TEST(MatchElements, AMovedPointLeavesItsTrianglesAlone) {
  Random random(5);
  const Mesh mesh = make_grid(9, 7);
  Mesh other = mesh;
  std::vector<float> values = positions_of(mesh);
  values[3 * 22 + 1] += 0.02f;
  std::memcpy(other.attributes[0].values.data(), values.data(), values.size() * sizeof(float));
  EXPECT_EQ(pairs(match(mesh, shuffled(other, random), {0.03})), mesh.faces.size());
  const ElementMatch found = match(mesh, shuffled(other, random), {0.01});
  for (size_t face = 0; face < mesh.faces.size(); ++face)
    EXPECT_EQ(found.partner[face] == kNoElement, std::ranges::count(mesh.faces[face], 22u) > 0) << face;
}

TEST(MatchElements, TrianglesThatStandTwiceCountTwice) {
  const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
  const Mesh twice = make_mesh(corners, {{0, 1, 2}, {0, 1, 2}, {1, 3, 2}});
  const Mesh other = make_mesh(corners, {{0, 1, 2}, {1, 3, 2}, {3, 2, 1}});
  EXPECT_EQ(pairs(match(twice, twice, {0})), 3u);
  EXPECT_EQ(pairs(match(twice, other, {0})), 2u);
  EXPECT_EQ(pairs(match(other, twice, {0.2})), 2u);
}

TEST(MatchElements, ManyCopiesOfOneTriangleTakeNoLonger) {
  Mesh mesh = make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {});
  for (int i = 0; i < 300'000; ++i) mesh.faces.push_back({0, 1, 2});
  EXPECT_EQ(pairs(match(mesh, mesh, {0.01})), mesh.faces.size());
}

TEST(MatchElements, WhatCannotBeToldApartInTimeIsAnError) {
  // All elements are within the limits of each other, except in the last column, by which they cannot be looked
  // up.
  constexpr uint32_t kCount = 2000;
  Mesh mesh = make_mesh(std::vector<float>(3 * kCount, 0.5f), {});
  std::vector<float> place(kCount * 2, 0.0f), ids(kCount);
  for (uint32_t i = 0; i < kCount; ++i) mesh.faces.push_back({i, i, i});
  std::iota(ids.begin(), ids.end(), 0.0f);
  mesh.attributes.push_back(make_attribute("TEXCOORD_0", ComponentType::kFloat32, 2, false, place));
  mesh.attributes.push_back(make_attribute("_ID", ComponentType::kFloat32, 1, false, ids));
  Mesh other = mesh;
  std::ranges::reverse(other.faces);
  for (float& id : ids) id += 0.75f;
  other.attributes[2] = make_attribute("_ID", ComponentType::kFloat32, 1, false, ids);
  const ElementBag a = bag_of(mesh, {0.1, 0.1, 0.0}), b = bag_of(other, {0.1, 0.1, 0.5});
  const auto found = match_elements(ElementPair(a, b, {false, false, false}), TearSearch::kNone, 1000);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.status().code(), StatusCode::kRuntimeFailure);
}

// The size of a maximum matching within `within`, found without the code under test, over all subsets of `b`.
size_t exhaustive_pairs(const Mesh& a, const Mesh& b, double within) {
  const std::vector<float> of_a = positions_of(a), of_b = positions_of(b);
  const auto fits = [&](size_t face_a, size_t face_b) {
    for (size_t turn = 0; turn < 3; ++turn) {
      bool all = true;
      for (size_t i = 0; i < 9; ++i) {
        const uint32_t point_a = a.faces[face_a][i / 3], point_b = b.faces[face_b][(i / 3 + turn) % 3];
        all &= std::fabs(static_cast<double>(of_a[3 * point_a + i % 3]) -
                         static_cast<double>(of_b[3 * point_b + i % 3])) <= within;
      }
      if (all) return true;
    }
    return false;
  };
  std::vector<size_t> best(size_t{1} << b.faces.size(), 0);
  for (size_t face = 0; face < a.faces.size(); ++face) {
    std::vector<size_t> next = best;
    for (size_t used = 0; used < best.size(); ++used)
      for (size_t other = 0; other < b.faces.size(); ++other)
        if ((used >> other & 1) == 0 && fits(face, other)) {
          size_t& with = next[used | size_t{1} << other];
          with = std::max(with, best[used] + 1);
        }
    best = std::move(next);
  }
  return *std::ranges::max_element(best);
}

TEST(MatchElements, FindsAsManyPairsAsAnExhaustiveSearch) {
  Random random(6);
  size_t incomplete = 0, ambiguous = 0;
  for (int round = 0; round < 3000; ++round) {
    // Few positions, so close that many are within the limit of each other.
    const double within = 0.1 * static_cast<double>(1 + random() % 4);
    const auto soup = [&](size_t count) {
      std::vector<float> values;
      for (size_t i = 0; i < 9 * count; ++i)
        values.push_back(
            i % 3 == 2 ? 0.0f : 0.125f * static_cast<float>(random() % (3 + static_cast<size_t>(round) % 5)));
      Faces faces;
      for (uint32_t i = 0; i < count; ++i) faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
      return make_mesh(values, faces);
    };
    const size_t count = 1 + random() % 7;
    const Mesh a = soup(count);
    Mesh b = soup(random() % 3 == 0 ? count + 1 : count);
    if (round % 2 == 0) {
      b = shuffled(a, random);
      std::vector<float> values = positions_of(b);
      for (float& value : values)
        value += static_cast<float>(within) * (static_cast<float>(random() % 5) - 2) / 2;
      std::memcpy(b.attributes[0].values.data(), values.data(), values.size() * sizeof(float));
    }
    const ElementMatch found = match(a, b, {within + 1e-6});
    ASSERT_EQ(pairs(found), exhaustive_pairs(a, b, within + 1e-6)) << "round " << round;
    std::vector<uint8_t> taken(b.faces.size());
    for (size_t face = 0; face < count; ++face) {
      if (found.partner[face] == kNoElement) continue;
      ASSERT_FALSE(taken[found.partner[face]]++);
      Mesh one = a, other = b;
      one.faces = {a.faces[face]};
      other.faces = {b.faces[found.partner[face]]};
      ASSERT_EQ(exhaustive_pairs(one, other, within + 1e-6), 1u);
    }
    incomplete += pairs(found) < count;
    ambiguous += round % 2 == 0 && pairs(found) == count;
  }
  EXPECT_GT(incomplete, 300u);
  EXPECT_GT(ambiguous, 300u);
}

TEST(MatchElements, ACrackIsATear) {
  // Two triangles share an edge. In the other mesh one end of it is two points, both within the limit.
  const Mesh whole = make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, {{0, 1, 2}, {1, 3, 2}});
  const Mesh torn = make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 1.01f, 0, 0}, {{0, 1, 2}, {4, 3, 2}});
  const ElementMatch found = match(whole, torn, {0.05});
  EXPECT_EQ(pairs(found), 2u);
  ASSERT_TRUE(found.tear);
  EXPECT_TRUE(found.tear->in_b);
  EXPECT_EQ(found.tear->elements, (std::array<uint32_t, 2>{0, 1}));
  EXPECT_EQ(found.tear->corners, (std::array<int, 2>{1, 0}));
  // In the opposite direction this is normal for quantization.
  EXPECT_FALSE(match(torn, whole, {0.05}).tear);
}

TEST(MatchElements, ValuesThatAreNoNumbersEqualThemselves) {
  const float nan = std::nanf("");
  const Mesh mesh = make_mesh({nan, 0, 0, 1, -INFINITY, 0, 0, 1, 0}, {{0, 1, 2}});
  const Mesh zeros = make_mesh({nan, -0.0f, 0, 1, -INFINITY, 0, -0.0f, 1, 0}, {{1, 2, 0}});
  const Mesh other = make_mesh({nan, 0, 0, 1, INFINITY, 0, 0, 1, 0}, {{0, 1, 2}});
  for (const double within : {0.0, 0.1}) {
    EXPECT_EQ(pairs(match(mesh, mesh, {within})), 1u);
    EXPECT_EQ(pairs(match(mesh, zeros, {within})), 1u);
    EXPECT_EQ(pairs(match(mesh, other, {within})), 0u);
  }
}

}  // namespace
}  // namespace psplit
