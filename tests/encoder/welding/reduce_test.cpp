#include "encoder/welding/reduce.h"

#include <gtest/gtest.h>

#include <set>

#include "encoder/coding/grid_places.h"
#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

TEST(Reduce, MergesPointsThatAreEqualInAllAttributes) {
  Mesh mesh;
  mesh.point_count = 4;
  mesh.attributes = {float_attribute("POSITION", 1, {1, 2, 1, 1}), float_attribute("_A", 1, {5, 5, 5, 6})};
  mesh.faces = {{0, 1, 2}, {3, 2, 1}};
  const ReducedMesh reduced = reduce(mesh, {}, ThreadPool(1));
  EXPECT_EQ(reduced.source_point, (std::vector<uint32_t>{0, 1, 3}));
  EXPECT_EQ(reduced.merged_points, 1u);
  EXPECT_EQ(reduced.mesh.point_count, 3u);
  EXPECT_EQ(reduced.mesh.faces[0], (std::array<uint32_t, 3>{0, 1, 0}));
  EXPECT_EQ(reduced.mesh.faces[1], (std::array<uint32_t, 3>{2, 0, 1}));
  const Attribute first = float_attribute("POSITION", 1, {1, 2, 1}),
                  second = float_attribute("_A", 1, {5, 5, 6});
  EXPECT_EQ(reduced.mesh.attributes[0].values, first.values);
  EXPECT_EQ(reduced.mesh.attributes[1].values, second.values);
}

// Point 1 equals point 0, which makes the second face degenerate; no face uses point 4.
Mesh with_everything_to_drop() {
  Mesh mesh;
  mesh.point_count = 5;
  mesh.attributes = {float_attribute("POSITION", 1, {1, 1, 2, 3, 4})};
  mesh.faces = {{1, 2, 3}, {0, 1, 3}};
  return mesh;
}

TEST(Reduce, DropsWhatTheOptionsName) {
  const ReducedMesh reduced =
      reduce(with_everything_to_drop(), {.drop_degenerate = true, .drop_unused = true}, ThreadPool(1));
  EXPECT_EQ(reduced.mesh.point_count, 3u);
  ASSERT_EQ(reduced.mesh.faces.size(), 1u);
  EXPECT_EQ(reduced.mesh.faces[0], (std::array<uint32_t, 3>{0, 1, 2}));
  EXPECT_EQ(reduced.source_point, (std::vector<uint32_t>{0, 2, 3}));
  EXPECT_EQ(reduced.merged_points, 1u);
  EXPECT_EQ(reduced.dropped_faces, 1u);
  EXPECT_EQ(reduced.dropped_points, 1u);
}

TEST(Reduce, KnowsStoredPointsBefore) {
  const Mesh mesh = with_everything_to_drop();
  const std::vector<std::byte> extra = {std::byte{1}, std::byte{2}, std::byte{0}, std::byte{0}, std::byte{0}};
  for (int k = 0; k < 16; ++k) {
    const ReduceOptions options{(k & 1) != 0, (k & 2) != 0, (k & 4) != 0};
    const auto more = std::span(extra).first(k < 8 ? 0 : extra.size());
    const ReducedMesh reduced = reduce(mesh, options, ThreadPool(2), more, more.size() / mesh.point_count);
    const std::vector<uint8_t> stored =
        stored_points(mesh, options, ThreadPool(2), more, more.size() / mesh.point_count);
    std::set<float> expected, actual;  // values, because either of two equal points may be the stored one
    const auto value = [&](uint32_t point) {
      return reinterpret_cast<const float*>(mesh.attributes[0].values.data())[point];
    };
    for (const uint32_t point : reduced.source_point) expected.insert(value(point));
    for (uint32_t point = 0; point < mesh.point_count; ++point)
      if (stored[point] != 0) actual.insert(value(point));
    EXPECT_EQ(actual, expected) << k;
  }
}

// Points 0 and 5 are at one place. On the grid they have the same value, too.
TEST(Reduce, MergesPointsThatAreEqualOnTheirGrids) {
  Mesh mesh;
  mesh.point_count = 6;
  mesh.attributes = {float_attribute("POSITION", 3, {0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, 0, 1, 0, 0, 0}),
                     float_attribute("_A", 1, {1, 2, 3, 4, 5, 1.1f})};
  const std::vector<AttributeCoding> codings = {{10, false, {-1, -1, -1}, 2}, {4, false, {0}, 15}};
  const ComparedBytes compared = places_on_grids(mesh, codings);
  const auto merged = [&](const Faces& faces, const ReduceOptions& options) {
    mesh.faces = faces;
    return reduce(mesh, options, ThreadPool(1)).merged_points;
  };
  EXPECT_EQ(merged({{0, 1, 2}, {5, 2, 3}}, {.compared = compared}), 1u);
  EXPECT_EQ(reduce(mesh, {.compared = compared}, ThreadPool(1)).mesh.faces[1],
            (std::array<uint32_t, 3>{0, 2, 3}));
  EXPECT_EQ(merged({{0, 1, 2}, {5, 2, 3}}, {}), 0u);
  EXPECT_EQ(merged({{0, 1, 2}, {5, 2, 3}}, {.keep_duplicates = true, .compared = compared}), 0u);
  // A face would become degenerate, and the edge from 0 to 2 would get a third face.
  EXPECT_EQ(merged({{0, 1, 2}, {5, 2, 3}, {0, 5, 1}}, {.compared = compared}), 0u);
  EXPECT_EQ(merged({{0, 1, 2}, {5, 2, 3}, {0, 2, 4}}, {.compared = compared}), 0u);
  // Positions decide the topology, so they must be equal themselves.
  mesh.attributes[0].values[15 * sizeof(float)] ^= std::byte{1};
  EXPECT_EQ(merged({{0, 1, 2}, {5, 2, 3}}, {.compared = compared}), 0u);
}

TEST(Reduce, ExtraBytesKeepPointsApart) {
  const std::vector<std::byte> extra = {std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}, std::byte{0}};
  const ReducedMesh reduced =
      reduce(with_everything_to_drop(), {.drop_degenerate = true}, ThreadPool(1), extra, 1);
  EXPECT_EQ(reduced.mesh.point_count, 5u);
  EXPECT_EQ(reduced.dropped_faces, 0u);
}

TEST(Reduce, KeepsEverythingWhenAsked) {
  const ReducedMesh reduced = reduce(with_everything_to_drop(), {.keep_duplicates = true}, ThreadPool(1));
  EXPECT_EQ(reduced.source_point, (std::vector<uint32_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(reduced.mesh.faces, with_everything_to_drop().faces);
}

}  // namespace
}  // namespace psplit
