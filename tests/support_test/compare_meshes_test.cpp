#include "tests/support/compare_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <set>
#include <utility>

#include "tests/support/expect.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

float get(const Attribute& attribute, size_t index) {
  float value;
  std::memcpy(&value, attribute.values.data() + index * sizeof value, sizeof value);
  return value;
}
void put(Attribute& attribute, size_t index, float value) {
  std::memcpy(attribute.values.data() + index * sizeof value, &value, sizeof value);
}

// A mesh with other numbers: points and faces are reordered, and corners are rotated.
Mesh renumbered(const Mesh& mesh) {
  std::vector<uint32_t> order(mesh.point_count);
  std::iota(order.begin(), order.end(), 0u);
  uint64_t state = 7;
  const auto shuffle = [&](auto& items) {
    for (size_t i = items.size(); i > 1; --i) {
      state = state * 6364136223846793005u + 1442695040888963407u;
      std::swap(items[i - 1], items[(state >> 33) % i]);
    }
  };
  shuffle(order);
  Mesh other = mesh;
  for (size_t a = 0; a < mesh.attributes.size(); ++a) {
    const size_t stride = mesh.attributes[a].stride();
    for (uint32_t p = 0; p < mesh.point_count; ++p)
      std::memcpy(other.attributes[a].values.data() + order[p] * stride,
                  mesh.attributes[a].values.data() + p * stride, stride);
  }
  for (size_t f = 0; f < other.faces.size(); ++f) {
    for (uint32_t& point : other.faces[f]) point = order[point];
    std::rotate(other.faces[f].begin(), other.faces[f].begin() + static_cast<std::ptrdiff_t>(f % 3),
                other.faces[f].end());
  }
  shuffle(other.faces);
  std::reverse(other.attributes.begin(), other.attributes.end());
  return other;
}

// The values that a decoder reconstructs from a grid. Every `nudge`-th value is rounded to the other side.
Mesh quantized(const Mesh& mesh, const Tolerance& grid, size_t nudge) {
  Mesh other = mesh;
  Attribute& position = other.attributes[0];
  const auto steps = static_cast<float>((1 << grid.bits) - 1);
  for (size_t i = 0; i < size_t{3} * mesh.point_count; ++i) {
    const float origin = grid.origin[i % 3];
    float index = std::floor((get(position, i) - origin) * (steps / grid.range) + 0.5f);
    if (nudge > 0 && i % nudge == 0) index += index > 0 ? -1.0f : 1.0f;
    put(position, i, origin + index * (grid.range / steps));
  }
  return other;
}

Mesh sample() {
  for (const NamedMesh& named : procedural_meshes())
    if (named.name == "terrain") return named.mesh;
  ADD_FAILURE() << "no terrain";
  return {};
}

TEST(Catalogue, HoldsValidMeshesWithNamesOfTheirOwn) {
  std::vector<std::string> names;
  for (const auto& [name, mesh] : all_meshes()) {
    names.push_back(name);
    EXPECT_NE(mesh.find("POSITION"), nullptr) << name;
    EXPECT_FALSE(mesh.faces.empty()) << name;
    for (const auto& face : mesh.faces) EXPECT_LT(std::ranges::max(face), mesh.point_count) << name;
    for (const Attribute& attribute : mesh.attributes)
      EXPECT_EQ(attribute.values.size(), attribute.stride() * mesh.point_count) << name;
  }
  std::ranges::sort(names);
  EXPECT_EQ(std::ranges::adjacent_find(names), names.end());
}

TEST(Catalogue, HoldsTheTopologiesThatItNames) {
  const auto euler = [](const std::string& wanted) -> int64_t {
    for (const auto& [name, mesh] : nasty_meshes()) {
      if (name != wanted) continue;
      std::set<std::pair<uint32_t, uint32_t>> edges;
      for (const auto& face : mesh.faces)
        for (size_t i = 0; i < 3; ++i) edges.insert(std::minmax(face[i], face[(i + 1) % 3]));
      return int64_t{mesh.point_count} - static_cast<int64_t>(edges.size()) +
             static_cast<int64_t>(mesh.faces.size());
    }
    ADD_FAILURE() << wanted << " is missing";
    return 0;
  };
  EXPECT_EQ(euler("torus"), 0);
  EXPECT_EQ(euler("klein bottle"), 0);
  EXPECT_EQ(euler("moebius strip"), 0);
  EXPECT_EQ(euler("torus chain of genus 144"), 2 - 2 * 144);
  EXPECT_EQ(euler("two cones sharing a tip"), 1);
}

TEST(CompareMeshes, SeesThroughAnyNumbering) {
  for (const auto& [name, mesh] : all_meshes()) EXPECT_EQ(compare_meshes(mesh, renumbered(mesh)), "") << name;
}

TEST(CompareMeshes, FindsOneFaceTurnedOver) {
  Mesh other = sample();
  std::swap(other.faces[100][0], other.faces[100][1]);
  const std::string difference = compare_meshes(sample(), renumbered(other));
  EXPECT_TRUE(contains(difference, "mirror image"));
}

TEST(CompareMeshes, FindsAMissingFaceAndARepeatedOne) {
  Mesh other = sample();
  other.faces.pop_back();
  EXPECT_NE(compare_meshes(sample(), other), "");
  other.faces.push_back(other.faces[0]);
  EXPECT_NE(compare_meshes(sample(), other), "");
}

TEST(CompareMeshes, FindsACornerOnTheWrongPoint) {
  Mesh other = sample();
  other.faces[7][1] = other.faces[300][0];
  EXPECT_NE(compare_meshes(sample(), other), "");
}

TEST(CompareMeshes, FindsOneChangedBitOfAnyAttribute) {
  for (const auto& [name, mesh] : nasty_meshes()) {
    if (mesh.point_count > 1000) continue;
    for (size_t a = 0; a < mesh.attributes.size(); ++a) {
      Mesh other = mesh;
      std::byte& value = other.attributes[a].values[other.attributes[a].values.size() / 2];
      value ^= std::byte{1};
      EXPECT_NE(compare_meshes(mesh, renumbered(other)), "") << name << ": " << mesh.attributes[a].semantic;
    }
  }
}

TEST(CompareMeshes, TellsZerosApartWhenExact) {
  const Mesh mesh = make_grid(2, 2);
  Mesh other = mesh;
  put(other.attributes[0], 2, -0.0f);
  EXPECT_NE(compare_meshes(mesh, other), "");
}

TEST(CompareMeshes, FindsAnExtraPoint) {
  const Mesh mesh = make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0}, {{0, 1, 2}});
  const Mesh one_more = make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0}, {{0, 1, 2}});
  const Mesh another = make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0}, {{0, 1, 2}});
  EXPECT_NE(compare_meshes(mesh, one_more), "");
  EXPECT_NE(compare_meshes(one_more, another), "");
  EXPECT_EQ(compare_meshes(another, another), "");
}

TEST(CompareMeshes, FindsTwinPointsThatChangedPlaces) {
  // Two faces with six points. In the other mesh, one of two equal points is used twice and the other once.
  const Mesh apart = make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, -1, 0}, {{0, 1, 2}, {3, 4, 5}});
  const Mesh shared =
      make_mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, -1, 0}, {{0, 1, 2}, {3, 0, 5}});
  EXPECT_NE(compare_meshes(apart, shared), "");
}

TEST(CompareMeshes, FindsOtherTypesAndMissingAttributes) {
  const Mesh mesh = sample();
  Mesh other = mesh;
  other.attributes.pop_back();
  EXPECT_NE(compare_meshes(mesh, other), "");
  EXPECT_NE(compare_meshes(other, mesh), "");
  other = mesh;
  other.attributes[1].normalized = true;
  EXPECT_NE(compare_meshes(mesh, other), "");
  other = mesh;
  other.faces[0][0] = mesh.point_count;
  EXPECT_NE(compare_meshes(mesh, other), "");
}

TEST(CompareMeshes, AcceptsTheGridAndRoundingToItsNeighbours) {
  const Mesh mesh = sample();
  for (const int bits : {6, 11, 14, 20}) {
    const Tolerance grid = grid_tolerance(bits, {-1.1f, -1.1f, -1.1f}, 2.2f);
    const Tolerance tolerances[] = {grid, exact_tolerance(), exact_tolerance()};
    for (const size_t nudge : {0u, 7u, 5000u})
      EXPECT_EQ(compare_meshes(mesh, renumbered(quantized(mesh, grid, nudge)), tolerances), "")
          << bits << " " << nudge;
    EXPECT_NE(compare_meshes(mesh, renumbered(quantized(mesh, grid, 0))), "");
  }
}

TEST(CompareMeshes, FindsAValueTwoStepsAway) {
  const Mesh mesh = sample();
  const Tolerance grid = grid_tolerance(14, {-1.1f, -1.1f, -1.1f}, 2.2f);
  const Tolerance tolerances[] = {grid, exact_tolerance(), exact_tolerance()};
  Mesh other = quantized(mesh, grid, 0);
  Attribute& position = other.attributes[0];
  put(position, 500, get(position, 500) + 2.0f * 2.2f / 16383);
  EXPECT_NE(compare_meshes(mesh, renumbered(other), tolerances), "");
}

TEST(CompareMeshes, MatchesNormalsByAngle) {
  const Mesh mesh = sample();
  const auto tilted = [&](float shift) {
    Mesh other = mesh;
    Attribute& normal = other.attributes[1];
    for (size_t p = 0; p < mesh.point_count; p += 3) {
      const float x = get(normal, 3 * p) + shift, y = get(normal, 3 * p + 1), z = get(normal, 3 * p + 2);
      const float length = std::sqrt(x * x + y * y + z * z);
      for (size_t i = 0; i < 3; ++i) put(normal, 3 * p + i, std::array{x, y, z}[i] / length);
    }
    return renumbered(other);
  };
  ASSERT_EQ(mesh.attributes[1].semantic, "NORMAL");
  const Tolerance tolerances[] = {exact_tolerance(), octahedral_tolerance(10), exact_tolerance()};
  EXPECT_EQ(compare_meshes(mesh, tilted(0.001f), tolerances), "");
  EXPECT_NE(compare_meshes(mesh, tilted(0.02f), tolerances), "");
}

TEST(CompareMeshes, PairsEqualFacesThatOnlyNormalsTellApart) {
  // A triangle occurs three times, each with a normal of its own. The triangles pair in any order.
  std::vector<float> positions, normals;
  for (int i = 0; i < 3; ++i) positions.insert(positions.end(), {0, 0, 0, 1, 0, 0, 0, 1, 0});
  for (const float x : {0.0f, 0.6f, -0.6f})
    for (int i = 0; i < 3; ++i) normals.insert(normals.end(), {x, 0, std::sqrt(1 - x * x)});
  Mesh mesh = make_mesh(positions, {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}});
  mesh.attributes.push_back(make_attribute("NORMAL", ComponentType::kFloat32, 3, false, normals));
  const Tolerance tolerances[] = {exact_tolerance(), octahedral_tolerance(8)};
  Mesh other = mesh;
  std::reverse(other.faces.begin(), other.faces.end());
  EXPECT_EQ(compare_meshes(mesh, renumbered(other), tolerances), "");
  for (size_t i = 9; i < 18; ++i) put(other.attributes[1], i, get(mesh.attributes[1], i - 9));
  EXPECT_NE(compare_meshes(mesh, renumbered(other), tolerances), "");
}

TEST(CompareMeshes, RefusesTolerancesThatDoNotFit) {
  const Mesh mesh = make_grid(2, 2);
  const Tolerance too_many[] = {exact_tolerance(), exact_tolerance()};
  const Tolerance flat[] = {grid_tolerance(8, {0, 0}, 1)};
  EXPECT_NE(compare_meshes(mesh, mesh, too_many), "");
  EXPECT_NE(compare_meshes(mesh, mesh, flat), "");
}

}  // namespace
}  // namespace psplit
