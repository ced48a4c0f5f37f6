// The tree of a point cloud with whole coordinates: the bytes that libdraco's encoder writes. The core has the
// decoder, and says what a tree is (kd_tree.h).
//
// Devillers, Gandoin: Geometric compression for interactive transmission, 2000.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "psplit/mesh.h"

namespace psplit {

// Points as rows of numbers: a coordinate for each axis, then the number of the point.
struct TreePoints {
  static constexpr uint32_t kRowsBehind = 8;

  uint32_t axis_count = 0, count = 0;
  Array<uint32_t> rows;  // and kRowsBehind more, of any numbers

  TreePoints(uint32_t axes, uint32_t points)
      : axis_count(axes), count(points), rows((size_t{points} + kRowsBehind) * row_size()) {
    std::fill(rows.end() - static_cast<std::ptrdiff_t>(kRowsBehind * row_size()), rows.end(), 0u);
  }
  size_t row_size() const { return size_t{axis_count} + 1; }
};

// The level of compression of a tree with `axis_count` axes at a speed of 0 to 10. Trees of more than 15 axes
// never have the highest level, which chooses the axis of each cut.
uint8_t tree_level(int speed, uint32_t axis_count);

// Appends the tree of fewer than 2^31 points and at least one axis. Returns the numbers of the points in the
// order in which the tree has them. The rows are used up.
std::vector<uint32_t> encode_tree(TreePoints points, uint8_t level, std::vector<uint8_t>& out);

}  // namespace psplit
