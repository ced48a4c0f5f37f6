// Divides space into cells of few points each.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "mesh_files/triangulate.h"
#include "psplit/base.h"

namespace psplit {

struct Box {
  Position low, high;
};

// Calls the function with all positions, block by block. Each call reads them again.
using PositionScan = std::function<Status(const std::function<void(std::span<const Position>)>&)>;

// A kd-tree whose leaves are the cells. Positions that are equal as numbers (also -0 and 0) are in one cell.
class CellTree {
 public:
  // One cell with all points. `box` holds their positions.
  CellTree(const Box& box, uint64_t point_count);

  uint32_t cell_count() const { return static_cast<uint32_t>(cells_.size()); }
  uint64_t point_count(uint32_t cell) const { return cells_[cell].point_count; }
  uint32_t cell_of(const Position& position) const {
    int32_t node = root_;
    while (node >= 0) node = nodes_[static_cast<size_t>(node)].next(position);
    return static_cast<uint32_t>(~node);
  }

  // Divides each cell of more than most_points[cell] points into cells of at most this number. Counts the
  // points on grids, several scans one after the other if a cell of a grid has too many. The memory is that of
  // a few grids. Errors: as for the scan; kUnsupported if too many points have one position, or if there
  // would be more than kMostCells.
  Status divide(std::span<const uint64_t> most_points, const PositionScan& scan);

  static constexpr uint32_t kMostCells = 0xffff;

 private:
  // A negative child is ~cell.
  struct Node {
    float split;
    uint32_t axis;
    std::array<int32_t, 2> children;
    int32_t next(const Position& position) const { return children[position[axis] < split ? 0 : 1]; }
  };
  struct Cell {
    Box box;
    uint64_t point_count = 0, most_points = 0;
    int32_t parent = -1;
    uint32_t side = 0;
  };
  class Grid;
  struct Range;
  Status split(uint32_t cell, const Grid& grid, const Range& range);
  void replace_child(const Cell& cell, int32_t child);

  int32_t root_ = ~0;
  std::vector<Node> nodes_;
  std::vector<Cell> cells_;
};

}  // namespace psplit
