// Triangles cover their polygon exactly: polygons of every size, concave ones, with straight edges, and with
// bridges to holes.
#include "mesh_files/triangulate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "tests/support/sanitizers.h"

namespace psplit {
namespace {

struct Cut {
  double area = 0;         // the sum of the triangles' areas
  double signed_area = 0;  // as `area`, but triangles against the polygon's orientation count as negative
  size_t triangles = 0;
  bool uses_every_corner = false;
};

double cross_z(const PrecisePosition& a, const PrecisePosition& b, const PrecisePosition& c) {
  return (double{b[0]} - a[0]) * (double{c[1]} - a[1]) - (double{b[1]} - a[1]) * (double{c[0]} - a[0]);
}

double polygon_area(const std::vector<PrecisePosition>& polygon) {
  double twice = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const PrecisePosition &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    twice += double{p[0]} * q[1] - double{q[0]} * p[1];
  }
  return twice / 2;
}

// A polygon in the plane z = 0.
Cut cut(Triangulator& triangulator, const std::vector<PrecisePosition>& polygon) {
  Cut result;
  std::set<uint32_t> used;
  for (const auto& [a, b, c] : triangulator.triangulate(polygon)) {
    const double area = cross_z(polygon[a], polygon[b], polygon[c]) / 2;
    result.signed_area += area;
    result.area += std::fabs(area);
    ++result.triangles;
    used.insert({a, b, c});
  }
  result.uses_every_corner = used.size() == polygon.size() && *used.rbegin() + 1 == polygon.size();
  return result;
}

void expect_covered(const std::vector<PrecisePosition>& polygon, const std::string& what) {
  Triangulator triangulator;
  // Beginning at every corner if there are few, and in both orientations.
  const size_t starts = std::min<size_t>(polygon.size(), 40);
  for (size_t start = 0; start < starts; ++start) {
    std::vector<PrecisePosition> turned(polygon);
    std::rotate(turned.begin(), turned.begin() + static_cast<ptrdiff_t>(start), turned.end());
    for (int side = 0; side < 2; ++side) {
      const double area = polygon_area(turned);
      const Cut found = cut(triangulator, turned);
      EXPECT_EQ(found.triangles, polygon.size() - 2) << what;
      EXPECT_TRUE(found.uses_every_corner) << what;
      EXPECT_NEAR(found.signed_area, area, std::fabs(area) * 1e-12) << what << " from " << start;
      EXPECT_NEAR(found.area, std::fabs(area), std::fabs(area) * 1e-12) << what << " from " << start;
      std::reverse(turned.begin(), turned.end());
    }
  }
  EXPECT_EQ(triangulator.irregular_count(), 0u) << what;
}

std::vector<PrecisePosition> star(size_t corners, float inner) {
  std::vector<PrecisePosition> polygon;
  for (size_t i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(corners);
    const float radius = i % 2 == 0 ? 1.0f : inner;
    polygon.push_back(
        {radius * static_cast<float>(std::cos(angle)), radius * static_cast<float>(std::sin(angle)), 0});
  }
  return polygon;
}

TEST(Triangulate, ConvexAndConcaveOfEverySizeAreCovered) {
  for (const size_t corners : {4u, 5u, 6u, 7u, 8u, 9u, 10u, 11u, 16u, 67u, 100u, 936u, 1000u})
    for (const float inner : {1.0f, 0.7f, 0.2f})
      expect_covered(star(corners, inner), std::to_string(corners) + " corners, " + std::to_string(inner));
  expect_covered(star(fewer_with_sanitizers(20'000), 0.5f), "many corners");
}

TEST(Triangulate, ConcaveQuadsAreCutAtTheirInnerCorner) {
  const std::vector<PrecisePosition> arrow = {{0, 0, 0}, {2, -2, 0}, {0, 4, 0}, {-2, -2, 0}};
  expect_covered(arrow, "arrow");
  Triangulator triangulator;
  EXPECT_EQ(
      triangulator.triangulate(std::vector<PrecisePosition>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}})[1],
      (Triangle{0, 2, 3}));
}

TEST(Triangulate, CornersOnStraightEdgesStay) {
  std::vector<PrecisePosition> square;
  for (int side = 0; side < 4; ++side)
    for (int i = 0; i < 5; ++i) {
      const auto t = static_cast<float>(i);
      const PrecisePosition corners[] = {{t, 0, 0}, {5, t, 0}, {5 - t, 5, 0}, {0, 5 - t, 0}};
      square.push_back(corners[side]);
    }
  expect_covered(square, "square of 20 corners");
  expect_covered({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {0, 3, 0}}, "triangle of 5 corners");
}

TEST(Triangulate, CombsSpiralsAndBridgesAreCovered) {
  std::vector<PrecisePosition> comb = {{0, -1, 0}};
  for (int i = 40; i >= 0; --i) {
    const auto x = static_cast<float>(i);
    comb.push_back({x, i % 2 == 0 ? 0.0f : 9.0f, 0});
  }
  expect_covered(comb, "comb");
  std::vector<PrecisePosition> spiral;
  for (int i = 0; i < 60; ++i) {
    const float angle = 0.3f * static_cast<float>(i), radius = 1 + 0.1f * static_cast<float>(i);
    spiral.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
  }
  for (int i = 59; i >= 0; --i) {
    const float angle = 0.3f * static_cast<float>(i), radius = 0.6f + 0.1f * static_cast<float>(i);
    spiral.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
  }
  expect_covered(spiral, "spiral");
  // A square with a square hole; the outline follows the bridge between them twice.
  expect_covered({{0, 0, 0},
                  {4, 0, 0},
                  {4, 4, 0},
                  {0, 4, 0},
                  {0, 0, 0},
                  {1, 1, 0},
                  {1, 3, 0},
                  {3, 3, 0},
                  {3, 1, 0},
                  {1, 1, 0}},
                 "a hole");
}

TEST(Triangulate, AnyPlaneAndAnyPlaceWill) {
  // The star in a slanted plane, far away, and tiny.
  for (const float scale : {1e-6f, 1.0f, 1e6f}) {
    std::vector<PrecisePosition> slanted;
    for (const auto& [x, y, z] : star(50, 0.3f))
      slanted.push_back({scale * (x + y), scale * (x - y), scale * (2 * y)});
    Triangulator triangulator;
    std::array<double, 3> sum{};
    double lengths = 0;
    for (const Triangle& triangle : triangulator.triangulate(slanted)) {
      const uint32_t a = triangle[0], b = triangle[1], c = triangle[2];
      std::array<double, 3> normal;
      for (size_t axis = 0; axis < 3; ++axis) {
        const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        const auto edge = [&](uint32_t to, size_t along) {
          return double{slanted[to][along]} - slanted[a][along];
        };
        normal[axis] = edge(b, u) * edge(c, v) - edge(b, v) * edge(c, u);
        sum[axis] += normal[axis];
      }
      lengths += std::hypot(normal[0], normal[1], normal[2]);
    }
    // All triangles have the same orientation: no area is covered twice.
    EXPECT_NEAR(lengths, std::hypot(sum[0], sum[1], sum[2]), lengths * 1e-5);
    EXPECT_EQ(triangulator.irregular_count(), 0u);
  }
}

TEST(Triangulate, WhatHasNoInsideStillGetsItsTriangles) {
  Triangulator triangulator;
  const std::vector<PrecisePosition> point(7, PrecisePosition{1, 2, 3});
  EXPECT_EQ(triangulator.triangulate(point).size(), 5u);
  EXPECT_EQ(triangulator.irregular_count(), 1u);
  std::vector<PrecisePosition> pentagram;
  for (int i = 0; i < 5; ++i) pentagram.push_back(star(5, 1)[static_cast<size_t>(2 * i % 5)]);
  EXPECT_EQ(triangulator.triangulate(pentagram).size(), 3u);
  const std::vector<PrecisePosition> line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {1, 0, 0}};
  EXPECT_EQ(triangulator.triangulate(line).size(), 3u);
  const std::vector<PrecisePosition> bow = {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1.5f, 0}};
  EXPECT_EQ(triangulator.triangulate(bow).size(), 2u);
}

// A random polygon crosses itself everywhere: triangles at its corners contain many other corners.
TEST(Triangulate, HostilePolygonsTakeTimeThatGrowsWithTheirSize) {
  Triangulator triangulator;
  uint32_t random = 1;
  std::vector<PrecisePosition> noise;
  for (size_t i = 0; i < fewer_with_sanitizers(100'000); ++i) {
    random = random * 1664525 + 1013904223;
    const auto x = static_cast<float>(random >> 16);
    random = random * 1664525 + 1013904223;
    noise.push_back({x, static_cast<float>(random >> 16), 0});
  }
  EXPECT_EQ(triangulator.triangulate(noise).size(), noise.size() - 2);
  EXPECT_EQ(triangulator.irregular_count(), 1u);
}

}  // namespace
}  // namespace psplit
