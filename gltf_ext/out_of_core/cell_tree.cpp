#include "gltf_ext/out_of_core/cell_tree.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace psplit {
namespace {

constexpr size_t kAxes = 3;
constexpr uint32_t kSlabs = 64;      // of a grid along an axis
constexpr size_t kGridsAtOnce = 16;  // a MiB each

}  // namespace

// A part of a grid: slabs from low to high - 1 along each axis.
struct CellTree::Range {
  std::array<uint32_t, kAxes> low, high;
};

// Counts of points on kSlabs * kSlabs * kSlabs boxes. Slab k of an axis has the positions from planes[k] up to
// planes[k + 1], so that "below plane k" and "in a slab below k" are the same.
class CellTree::Grid {
 public:
  explicit Grid(const Box& box) : counts_(size_t{kSlabs} * kSlabs * kSlabs) {
    for (size_t axis = 0; axis < kAxes; ++axis) {
      const double low = double{box.low[axis]}, extent = double{box.high[axis]} - low;
      for (uint32_t k = 0; k < kSlabs; ++k) planes_[axis][k] = static_cast<float>(low + extent * k / kSlabs);
      planes_[axis][kSlabs] = box.high[axis];
      slabs_per_unit_[axis] = extent > 0 ? kSlabs / extent : 0;
    }
  }

  void add(const Position& position) {
    ++counts_[(size_t{slab(0, position[0])} * kSlabs + slab(1, position[1])) * kSlabs + slab(2, position[2])];
  }

  float plane(size_t axis, uint32_t k) const { return planes_[axis][k]; }

  // The number of points in each slab of the range along an axis.
  std::array<uint64_t, kSlabs> slab_counts(const Range& range, size_t axis) const {
    std::array<uint64_t, kSlabs> sums{};
    std::array<uint32_t, kAxes> at{};
    for (at[0] = range.low[0]; at[0] < range.high[0]; ++at[0])
      for (at[1] = range.low[1]; at[1] < range.high[1]; ++at[1])
        for (at[2] = range.low[2]; at[2] < range.high[2]; ++at[2])
          sums[at[axis]] += counts_[(size_t{at[0]} * kSlabs + at[1]) * kSlabs + at[2]];
    return sums;
  }

 private:
  uint32_t slab(size_t axis, float value) const {
    if (slabs_per_unit_[axis] == 0) return 0;
    const std::array<float, kSlabs + 1>& planes = planes_[axis];
    const double estimate = (double{value} - double{planes[0]}) * slabs_per_unit_[axis];
    auto k = static_cast<uint32_t>(std::clamp(estimate, 0.0, double{kSlabs - 1}));
    while (k > 0 && value < planes[k]) --k;
    while (k + 1 < kSlabs && value >= planes[k + 1]) ++k;
    return k;
  }

  std::array<std::array<float, kSlabs + 1>, kAxes> planes_;
  std::array<double, kAxes> slabs_per_unit_;
  std::vector<uint32_t> counts_;
};

CellTree::CellTree(const Box& box, uint64_t point_count) : cells_{{box, point_count, 0, -1, 0}} {}

void CellTree::replace_child(const Cell& cell, int32_t child) {
  if (cell.parent < 0)
    root_ = child;
  else
    nodes_[static_cast<size_t>(cell.parent)].children[cell.side] = child;
}

Status CellTree::split(uint32_t index, const Grid& grid, const Range& whole) {
  Range range = whole;
  std::array<std::array<uint64_t, kSlabs>, kAxes> counts;
  size_t longest = kAxes;
  for (size_t axis = 0; axis < kAxes; ++axis) {
    counts[axis] = grid.slab_counts(range, axis);
    while (range.high[axis] - range.low[axis] > 1 && counts[axis][range.low[axis]] == 0) ++range.low[axis];
    while (range.high[axis] - range.low[axis] > 1 && counts[axis][range.high[axis] - 1] == 0)
      --range.high[axis];
  }
  Cell& cell = cells_[index];
  for (size_t axis = 0; axis < kAxes; ++axis) {
    cell.box.low[axis] = grid.plane(axis, range.low[axis]);
    cell.box.high[axis] = grid.plane(axis, range.high[axis]);
    const auto extent = [&](size_t a) { return double{cell.box.high[a]} - double{cell.box.low[a]}; };
    if (range.high[axis] - range.low[axis] > 1 && (longest == kAxes || extent(axis) > extent(longest)))
      longest = axis;
  }
  if (cell.point_count <= cell.most_points || longest == kAxes) return {};  // divide() looks at it again
  if (cells_.size() == kMostCells) return unsupported("the mesh would need more than 65535 parts");

  // The plane that divides the points most nearly as the cells that are needed on both sides.
  const uint64_t needed = (cell.point_count + cell.most_points - 1) / cell.most_points;
  const double wanted =
      static_cast<double>(cell.point_count) * static_cast<double>(needed / 2) / static_cast<double>(needed);
  uint64_t below = 0, best_below = 0;
  uint32_t best = 0;
  for (uint32_t k = range.low[longest] + 1; k < range.high[longest]; ++k) {
    below += counts[longest][k - 1];
    if (best == 0 ||
        std::fabs(static_cast<double>(below) - wanted) < std::fabs(static_cast<double>(best_below) - wanted)) {
      best = k;
      best_below = below;
    }
  }
  const auto node = static_cast<int32_t>(nodes_.size());
  const auto other = static_cast<uint32_t>(cells_.size());
  replace_child(cell, node);
  nodes_.push_back({grid.plane(longest, best),
                    static_cast<uint32_t>(longest),
                    {~static_cast<int32_t>(index), ~static_cast<int32_t>(other)}});
  Cell upper = cell;
  cell.parent = upper.parent = node;
  cell.side = 0;
  upper.side = 1;
  upper.point_count -= best_below;
  cell.point_count = best_below;
  cells_.push_back(upper);
  Range below_range = range, above_range = range;
  below_range.high[longest] = above_range.low[longest] = best;
  Status status = split(index, grid, below_range);
  return status.ok() ? split(other, grid, above_range) : std::move(status);
}

Status CellTree::divide(std::span<const uint64_t> most_points, const PositionScan& scan) {
  for (size_t i = 0; i < cells_.size(); ++i) cells_[i].most_points = std::max<uint64_t>(1, most_points[i]);
  for (;;) {
    std::vector<Grid> grids;
    std::vector<uint32_t> divided;
    constexpr uint8_t kNoGrid = 0xff;
    std::vector<uint8_t> grid_of_cell(cells_.size(), kNoGrid);
    for (uint32_t i = 0; i < cells_.size() && divided.size() < kGridsAtOnce; ++i) {
      const Cell& cell = cells_[i];
      if (cell.point_count <= cell.most_points) continue;
      const auto is_flat = [&](size_t axis) {
        return std::nextafter(cell.box.low[axis], INFINITY) >= cell.box.high[axis];
      };
      if (is_flat(0) && is_flat(1) && is_flat(2))
        return unsupported(std::to_string(cell.point_count) +
                           " points have nearly the same position: they do not fit into --memory");
      grid_of_cell[i] = static_cast<uint8_t>(grids.size());
      grids.emplace_back(cell.box);
      divided.push_back(i);
    }
    if (divided.empty()) return {};
    Status status = scan([&](std::span<const Position> positions) {
      for (const Position& position : positions)
        if (const uint8_t grid = grid_of_cell[cell_of(position)]; grid != kNoGrid) grids[grid].add(position);
    });
    for (size_t i = 0; i < divided.size() && status.ok(); ++i)
      status = split(divided[i], grids[i], {{0, 0, 0}, {kSlabs, kSlabs, kSlabs}});
    if (!status.ok()) return status;
  }
}

}  // namespace psplit
