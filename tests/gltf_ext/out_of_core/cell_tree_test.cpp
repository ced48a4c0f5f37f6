#include "gltf_ext/out_of_core/cell_tree.h"

#include <limits>
#include <random>

#include "tests/support/expect.h"

namespace psplit {
namespace {

Box box_of(const std::vector<Position>& positions) {
  Box box{positions[0], positions[0]};
  for (const Position& position : positions)
    for (size_t axis = 0; axis < 3; ++axis) {
      box.low[axis] = std::min(box.low[axis], position[axis]);
      box.high[axis] = std::max(box.high[axis], position[axis]);
    }
  return box;
}

PositionScan scan_of(const std::vector<Position>& positions, int* scans = nullptr) {
  return [&positions, scans](const auto& visit) {
    if (scans != nullptr) ++*scans;
    visit(std::span(positions));
    return Status();
  };
}

// Divides, and checks that each cell has the points that it claims, and at most `most`.
void expect_divided(const std::vector<Position>& positions, uint64_t most, uint32_t most_cells) {
  CellTree tree(box_of(positions), positions.size());
  must(tree.divide(std::vector<uint64_t>{most}, scan_of(positions)));
  std::vector<uint64_t> counts(tree.cell_count());
  for (const Position& position : positions) ++counts[tree.cell_of(position)];
  for (uint32_t cell = 0; cell < tree.cell_count(); ++cell) {
    EXPECT_EQ(counts[cell], tree.point_count(cell));
    EXPECT_LE(counts[cell], most);
    EXPECT_GT(counts[cell], 0u);
  }
  EXPECT_LE(tree.cell_count(), most_cells);
}

std::vector<Position> random_points(size_t count, float extent) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> value(-extent, extent);
  std::vector<Position> positions(count);
  for (Position& position : positions) position = {value(random), value(random), value(random)};
  return positions;
}

TEST(CellTree, CellsAreNearlyFull) { expect_divided(random_points(100000, 1), 1000, 150); }

TEST(CellTree, FlatMeshesAndLinesAreDivided) {
  std::vector<Position> positions = random_points(20000, 5);
  for (Position& position : positions) position[1] = 3;
  expect_divided(positions, 100, 400);
  for (Position& position : positions) position[2] = -0.0f;
  expect_divided(positions, 100, 400);
}

// One point far away makes one cell of the grid hold all others, again and again.
TEST(CellTree, FullCellsOfTheGridAreDividedAgain) {
  std::vector<Position> positions = random_points(20000, 1e-3f);
  positions.push_back({1e9f, 1e9f, -1e9f});
  expect_divided(positions, 500, 100);
  positions.push_back({std::numeric_limits<float>::max(), 0, std::numeric_limits<float>::lowest()});
  expect_divided(positions, 500, 100);
}

TEST(CellTree, MassesOfEqualPositionsAreAnError) {
  std::vector<Position> positions = random_points(1000, 1);
  positions.insert(positions.end(), 5000, Position{0.25f, 0.5f, 0.125f});
  CellTree tree(box_of(positions), positions.size());
  const Status status = tree.divide(std::vector<uint64_t>{1000}, scan_of(positions));
  EXPECT_EQ(status.code(), StatusCode::kUnsupported);
  EXPECT_TRUE(contains(status.message(), "nearly the same position"));
}

TEST(CellTree, DividesSingleCellsFurther) {
  const std::vector<Position> positions = random_points(10000, 1);
  CellTree tree(box_of(positions), positions.size());
  ASSERT_TRUE(tree.divide(std::vector<uint64_t>{5000}, scan_of(positions)).ok());
  const uint32_t before = tree.cell_count();
  std::vector<uint64_t> most(before, 10000);
  most[1] = 700;
  ASSERT_TRUE(tree.divide(most, scan_of(positions)).ok());
  EXPECT_GT(tree.cell_count(), before);
  std::vector<uint64_t> counts(tree.cell_count());
  for (const Position& position : positions) ++counts[tree.cell_of(position)];
  EXPECT_LE(counts[1], 700u);
  EXPECT_GT(counts[0], 700u);
}

TEST(CellTree, ZerosOfBothSignsShareACell) {
  std::vector<Position> positions;
  for (int i = 0; i < 64; ++i) positions.push_back({static_cast<float>(i - 32), 0, 0});
  CellTree tree(box_of(positions), positions.size());
  ASSERT_TRUE(tree.divide(std::vector<uint64_t>{1}, scan_of(positions)).ok());
  EXPECT_EQ(tree.cell_of({0.0f, 0.0f, -0.0f}), tree.cell_of({-0.0f, -0.0f, 0.0f}));
}

}  // namespace
}  // namespace psplit
