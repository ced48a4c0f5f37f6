#include "encoder/welding/weld.h"

#include <gtest/gtest.h>

#include <array>

#include "tests/support/procedural_meshes.h"

namespace psplit {
namespace {

TEST(LowestEqualRows, ComparesBits) {
  const Attribute rows = float_attribute("_A", 1, {0.0f, 1.0f, -0.0f, 1.0f, 0.0f});
  EXPECT_EQ(lowest_equal_rows(5, rows.values, 4, {}, ThreadPool(1)), (std::vector<uint32_t>{0, 1, 2, 1, 0}));
}

TEST(LowestEqualRows, KeepsGroupsApart) {
  const Attribute rows = float_attribute("_A", 1, {7, 7, 7, 7});
  EXPECT_EQ(lowest_equal_rows(4, rows.values, 4, std::vector<uint32_t>{0, 1, 0, 1}, ThreadPool(1)),
            (std::vector<uint32_t>{0, 1, 0, 1}));
}

// Enough rows for several shares of the hash table, each of which has some row five times.
TEST(LowestEqualRows, GivesTheSameOnAnyNumberOfThreads) {
  constexpr uint32_t kRows = 50'000, kDistinct = kRows / 5;
  std::vector<std::array<uint32_t, 3>> rows(kRows);
  std::vector<uint32_t> expected(kRows);
  for (uint32_t i = 0; i < kRows; ++i) {
    const uint32_t value = i * 7 % kDistinct;
    rows[i] = {value, 5, value * value};
    expected[i] = i % kDistinct;
  }
  const std::span<const std::byte> bytes = std::as_bytes(std::span(rows));
  for (const int threads : {1, 2, 3}) {
    const ThreadPool pool(threads);
    EXPECT_EQ(lowest_equal_rows(kRows, bytes, sizeof(rows[0]), {}, pool), expected);
    EXPECT_EQ(lowest_equal_rows(kRows, std::vector<std::byte>(kRows), 1, expected, pool), expected);
  }
}

TEST(FindDuplicates, NeedsEveryAttributeAndTheExtraBytesEqual) {
  Mesh mesh;
  mesh.point_count = 3;
  mesh.attributes = {float_attribute("POSITION", 3, {1, 2, 3, 1, 2, 3, 1, 2, 3}),
                     float_attribute("_A", 1, {4, 4, 5})};
  EXPECT_EQ(find_duplicates(mesh, {}, 0, ThreadPool(1)), (std::vector<uint32_t>{0, 0, 2}));
  const std::vector<std::byte> extra = {std::byte{1}, std::byte{2}, std::byte{1}};
  EXPECT_EQ(find_duplicates(mesh, extra, 1, ThreadPool(1)), (std::vector<uint32_t>{0, 1, 2}));
}

TEST(Weld, SharesValuesAroundAVertexOnly) {
  Mesh mesh;
  mesh.point_count = 4;
  mesh.attributes = {float_attribute("NORMAL", 1, {8, 8, 9, 8}),
                     float_attribute("POSITION", 3, {0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0}),
                     float_attribute("_A", 1, {1, 2, 1, 1})};
  const WeldedMesh welded = weld(mesh, ThreadPool(1));
  EXPECT_EQ(welded.value_of_point[1], (std::vector<uint32_t>{0, 0, 0, 3}));
  EXPECT_EQ(welded.value_of_point[0], (std::vector<uint32_t>{0, 0, 2, 3}));
  EXPECT_EQ(welded.value_of_point[2], (std::vector<uint32_t>{0, 1, 0, 3}));
}

TEST(Weld, KeepsFullDuplicatesApart) {
  Mesh mesh;
  mesh.point_count = 2;
  mesh.attributes = {float_attribute("POSITION", 3, {1, 2, 3, 1, 2, 3})};
  EXPECT_EQ(weld(mesh, ThreadPool(1)).value_of_point[0], (std::vector<uint32_t>{0, 1}));
  mesh.attributes.insert(mesh.attributes.begin(), float_attribute("_A", 1, {5, 5}));
  const WeldedMesh welded = weld(mesh, ThreadPool(1));
  EXPECT_EQ(welded.value_of_point[0], (std::vector<uint32_t>{0, 1}));
  EXPECT_EQ(welded.value_of_point[1], (std::vector<uint32_t>{0, 0}));
}

// Each value of point 3 is that of a lower point, but not of one lower point. Point 4 equals it.
TEST(Weld, KnowsFullDuplicatesFromPointsThatShareEachValue) {
  Mesh mesh;
  mesh.point_count = 5;
  mesh.attributes = {float_attribute("POSITION", 1, {1, 1, 1, 1, 1}), float_attribute("_A", 1, {5, 5, 6, 6, 6}),
                     float_attribute("_B", 1, {7, 8, 7, 8, 8})};
  const WeldedMesh welded = weld(mesh, ThreadPool(1));
  EXPECT_EQ(welded.value_of_point[1], (std::vector<uint32_t>{0, 0, 2, 2, 2}));
  EXPECT_EQ(welded.value_of_point[2], (std::vector<uint32_t>{0, 1, 0, 1, 4}));
}

}  // namespace
}  // namespace psplit
