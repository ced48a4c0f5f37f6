// The tree of a point cloud with whole coordinates: the bytes that libdraco's encoder writes. The core has the
// decoder, and says what a tree is (kd_tree.h).
//
// Devillers, Gandoin: Geometric compression for interactive transmission, 2000.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace psplit {

// Points as rows of numbers: a coordinate for each axis, then the number of the point.
struct TreePoints {
  uint32_t axis_count = 0;
  std::vector<uint32_t> rows;

  size_t row_size() const { return size_t{axis_count} + 1; }
  uint32_t count() const { return static_cast<uint32_t>(rows.size() / row_size()); }
};

// The level of compression that a tree of so many axes has at a speed, 0 to 10: of the highest level, which
// chooses the axis of each cut, up to 15 axes.
uint8_t tree_level(int speed, uint32_t axis_count);

// Appends the tree of fewer than 2^31 points and at least one axis. Returns the numbers of the points in the
// order in which the tree has them. The rows are used up.
std::vector<uint32_t> encode_tree(TreePoints points, uint8_t level, std::vector<uint8_t>& out);

}  // namespace psplit
