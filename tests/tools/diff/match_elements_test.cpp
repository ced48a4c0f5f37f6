// Which triangles find a partner, compared with an exhaustive search and on difficult values.
#include "tools/gltf_psplit/diff/match_elements.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>
#include <vector>

#include "gltf_ext/primitive/mesh_view.h"
#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"
#include "tests/support/sanitizers.h"

namespace psplit {
namespace {

using Random = std::mt19937;

ElementBag bag_of(const Mesh& mesh, const std::vector<double>& within, int corner_count = 3) {
  ElementBag bag(corner_count);
  const MeshView view = view_of(mesh);
  ElementPart part{view.indices, {}, {}};
  for (size_t i = 0; i < mesh.attributes.size(); ++i) {
    part.columns.push_back(view.attributes[i].values);
    part.limits.push_back({within[i], -1});
  }
  bag.add(std::move(part));
  return bag;
}

size_t pairs(const ElementMatch& match) {
  const auto count = std::ranges::count(match.has_partner[0], true);
  EXPECT_EQ(count, std::ranges::count(match.has_partner[1], true));
  return static_cast<size_t>(count);
}

// The limits come from `b`.
ElementMatch match(const Mesh& a, const Mesh& b, const std::vector<double>& within) {
  const ElementBag bag_a = bag_of(a, std::vector<double>(within.size(), 0.0)), bag_b = bag_of(b, within);
  const ElementPair pair(bag_a, bag_b, std::vector<bool>(within.size(), false));
  const ElementMatch found = must(match_elements(pair, TearSearch::kInB));
  // The result is the same in windows, unless too many elements are near each other.
  const Expected<ElementMatch> in_windows =
      match_elements(pair, TearSearch::kInB, {.window = (bag_a.size() + bag_b.size()) / 3});
  if (!in_windows) return found;
  EXPECT_EQ(in_windows->has_partner[0], found.has_partner[0]);
  EXPECT_EQ(pairs(*in_windows), pairs(found));
  EXPECT_EQ(in_windows->tear.has_value(), found.tear.has_value());
  return found;
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
  std::vector<float> values = values_of<float>(mesh.attributes[0]);
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

// Sanitizers watch a coarse grid and a fine one.
TEST(MatchElements, AnyGridOfPositionsIsWithinHalfAStep) {
  Random random(2);
  const bool all = !kHasSanitizers;
  for (const NamedMesh& named : procedural_meshes())
    for (const int bits : all ? std::vector{3, 5, 8, 14, 20} : std::vector{5, 14}) {
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
  std::vector<float> values = values_of<float>(mesh.attributes[0]);
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
  EXPECT_FALSE(found.has_partner[0][50]);
}

TEST(MatchElements, AMovedPointLeavesItsTrianglesAlone) {
  Random random(5);
  const Mesh mesh = make_grid(9, 7);
  Mesh other = mesh;
  std::vector<float> values = values_of<float>(mesh.attributes[0]);
  values[3 * 22 + 1] += 0.02f;
  std::memcpy(other.attributes[0].values.data(), values.data(), values.size() * sizeof(float));
  EXPECT_EQ(pairs(match(mesh, shuffled(other, random), {0.03})), mesh.faces.size());
  const ElementMatch found = match(mesh, shuffled(other, random), {0.01});
  for (size_t face = 0; face < mesh.faces.size(); ++face)
    EXPECT_NE(found.has_partner[0][face], std::ranges::count(mesh.faces[face], 22u) > 0) << face;
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
  mesh.faces.assign(fewer_with_sanitizers(300'000), {0, 1, 2});
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
  const auto found =
      match_elements(ElementPair(a, b, {false, false, false}), TearSearch::kNone, {.spare_tests = 1000});
  ASSERT_FALSE(found);
  EXPECT_EQ(found.status().code(), StatusCode::kRuntimeFailure);
}

// The size of a maximum matching within `within`, found without the code under test, over all subsets of `b`.
size_t exhaustive_pairs(const Mesh& a, const Mesh& b, double within) {
  const std::vector<float> of_a = values_of<float>(a.attributes[0]), of_b = values_of<float>(b.attributes[0]);
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
  constexpr size_t kRounds = fewer_with_sanitizers(3000);
  size_t incomplete = 0, ambiguous = 0;
  for (size_t round = 0; round < kRounds; ++round) {
    // Few positions, so close that many are within the limit of each other.
    const double within = 0.1 * static_cast<double>(1 + random() % 4);
    const auto soup = [&](size_t count) {
      std::vector<float> values;
      for (size_t i = 0; i < 9 * count; ++i)
        values.push_back(i % 3 == 2 ? 0.0f : 0.125f * static_cast<float>(random() % (3 + round % 5)));
      Faces faces;
      for (uint32_t i = 0; i < count; ++i) faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
      return make_mesh(values, faces);
    };
    const size_t count = 1 + random() % 7;
    const Mesh a = soup(count);
    Mesh b = soup(random() % 3 == 0 ? count + 1 : count);
    if (round % 2 == 0) {
      b = shuffled(a, random);
      std::vector<float> values = values_of<float>(b.attributes[0]);
      for (float& value : values)
        value += static_cast<float>(within) * (static_cast<float>(random() % 5) - 2) / 2;
      std::memcpy(b.attributes[0].values.data(), values.data(), values.size() * sizeof(float));
    }
    const ElementMatch found = match(a, b, {within + 1e-6});
    ASSERT_EQ(pairs(found), exhaustive_pairs(a, b, within + 1e-6)) << "round " << round;
    incomplete += pairs(found) < count;
    ambiguous += round % 2 == 0 && pairs(found) == count;
  }
  EXPECT_GT(incomplete, kRounds / 10);
  EXPECT_GT(ambiguous, kRounds / 10);
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

TEST(MatchElements, WindowsChangeNoResult) {
  Random random(7);
  Mesh mesh = make_grid(150, 10);
  std::vector<float> places = values_of<float>(mesh.attributes[0]);
  for (float& place : places) place *= 0.3701f;
  mesh.attributes[0] = make_attribute("POSITION", ComponentType::kFloat32, 3, false, places);
  Mesh quantized = mesh;
  quantize(quantized, 1.0 / 4096, 9);
  const double within = 1.0 / 8192 + 1e-6;
  const auto in_windows = [&](const Mesh& other) {
    const ElementBag a = bag_of(mesh, {0.0}), b = bag_of(other, {within});
    return must(match_elements(ElementPair(a, b, {false}), TearSearch::kInB, {.window = 600}));
  };
  const ElementMatch all = in_windows(shuffled(quantized, random));
  EXPECT_EQ(pairs(all), mesh.faces.size());
  EXPECT_FALSE(all.tear);
  EXPECT_GT(all.largest[0], within / 2);

  // A crack, and a triangle that is missing; each at every place.
  for (uint32_t point = 20; point < mesh.point_count; point += 97) {
    Mesh torn = quantized;
    std::vector<float> values = values_of<float>(torn.attributes[0]);
    const uint32_t copy = torn.point_count++;
    for (size_t c = 0; c < 3; ++c) values.push_back(values[size_t{3} * point + c]);
    values[size_t{3} * copy] = places[size_t{3} * point] + static_cast<float>(within / 4);
    torn.attributes[0] = make_attribute("POSITION", ComponentType::kFloat32, 3, false, values);
    for (auto& face : torn.faces)
      if (std::ranges::count(face, point) > 0) {
        std::ranges::replace(face, point, copy);
        break;
      }
    const ElementMatch found = in_windows(torn);
    EXPECT_EQ(pairs(found), mesh.faces.size());
    EXPECT_TRUE(found.tear) << point;
    torn.faces.erase(torn.faces.begin() + point);
    EXPECT_EQ(pairs(in_windows(torn)), mesh.faces.size() - 1);
  }
  // More elements at one place than a window holds.
  Mesh flat = mesh;
  for (Attribute& attribute : flat.attributes) std::ranges::fill(attribute.values, std::byte{0});
  const ElementBag a = bag_of(flat, {0.0}), b = bag_of(flat, {0.0});
  EXPECT_EQ(pairs(*match_elements(ElementPair(a, b, {false}), TearSearch::kNone, {.window = 600})),
            mesh.faces.size());
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
