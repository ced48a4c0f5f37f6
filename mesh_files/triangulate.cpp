#include "mesh_files/triangulate.h"

#include <algorithm>
#include <cmath>

namespace psplit {

std::span<const Triangle> Triangulator::triangulate(std::span<const PrecisePosition> polygon) {
  triangles_.clear();
  if (polygon.size() == 3) {
    triangles_.push_back({0, 1, 2});
  } else if (!project(polygon)) {
    ++irregular_count_;
    fan(polygon.size());
  } else if (polygon.size() == 4) {
    cut_quad();
  } else if (is_strictly_convex()) {
    fan(polygon.size());
  } else {
    cut_ears();
  }
  return triangles_;
}

// The plane is that of Newell's normal: the sum of the cross products of neighbouring corners, which is twice
// the area vector. The axis along which the normal is longest is dropped, which keeps the orientation of
// triangles.
bool Triangulator::project(std::span<const PrecisePosition> polygon) {
  std::array<double, 3> normal{};
  const PrecisePosition& origin = polygon[0];
  const auto from_origin = [&](size_t corner, size_t axis) { return polygon[corner][axis] - origin[axis]; };
  for (size_t i = 1; i + 1 < polygon.size(); ++i)
    for (size_t axis = 0; axis < 3; ++axis) {
      const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
      normal[axis] += from_origin(i, u) * from_origin(i + 1, v) - from_origin(i, v) * from_origin(i + 1, u);
    }
  size_t longest = 0;
  for (size_t axis = 1; axis < 3; ++axis)
    if (std::fabs(normal[axis]) > std::fabs(normal[longest])) longest = axis;
  if (!(std::fabs(normal[longest]) > 0)) return false;
  const size_t u = (longest + 1) % 3, v = (longest + 2) % 3;
  const double sign = normal[longest] > 0 ? 1 : -1;
  points_.clear();
  for (size_t i = 0; i < polygon.size(); ++i) points_.push_back({sign * from_origin(i, u), from_origin(i, v)});
  return true;
}

double Triangulator::turn(uint32_t a, uint32_t b, uint32_t c) const {
  const Point &p = points_[a], &q = points_[b], &r = points_[c];
  return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
}

// Convex: all corners turn left, and the outline goes around once, so its direction changes between leftwards
// and rightwards twice.
bool Triangulator::is_strictly_convex() const {
  const auto count = static_cast<uint32_t>(points_.size());
  int changes = 0;
  bool goes_right = points_[0].x >= points_[count - 1].x;
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t next = i + 1 == count ? 0 : i + 1, after = next + 1 == count ? 0 : next + 1;
    if (turn(i, next, after) <= 0) return false;
    const bool right = points_[next].x >= points_[i].x;
    changes += right != goes_right;
    goes_right = right;
  }
  return changes <= 2;
}

void Triangulator::fan(size_t corner_count) {
  for (uint32_t i = 1; i + 1 < corner_count; ++i) triangles_.push_back({0, i, i + 1});
}

// The diagonal from corner 0, unless only the other diagonal is inside.
void Triangulator::cut_quad() {
  const double kept = std::min(turn(0, 1, 2), turn(0, 2, 3)), other = std::min(turn(1, 2, 3), turn(1, 3, 0));
  if (kept <= 0 && other > kept)
    triangles_.insert(triangles_.end(), {{1, 2, 3}, {1, 3, 0}});
  else
    fan(4);
  irregular_count_ += std::max(kept, other) < 0;
}

size_t Triangulator::column(double x) const {
  return static_cast<size_t>(
      std::clamp((x - origin_.x) * cells_per_unit_.x, 0.0, static_cast<double>(cells_ - 1)));
}

size_t Triangulator::row(double y) const {
  return static_cast<size_t>(
      std::clamp((y - origin_.y) * cells_per_unit_.y, 0.0, static_cast<double>(cells_ - 1)));
}

void Triangulator::sort_reflex_corners() {
  const auto count = static_cast<uint32_t>(points_.size());
  is_reflex_.assign(count, 0);
  uint32_t reflex_count = 0;
  Point low = points_[0], high = points_[0];
  for (uint32_t i = 0; i < count; ++i) {
    is_reflex_[i] = turn(previous_[i], i, next_[i]) <= 0;
    reflex_count += is_reflex_[i];
    low = {std::min(low.x, points_[i].x), std::min(low.y, points_[i].y)};
    high = {std::max(high.x, points_[i].x), std::max(high.y, points_[i].y)};
  }
  constexpr double kMostCells = 1024;
  cells_ = static_cast<size_t>(std::clamp(std::sqrt(reflex_count / 2.0), 1.0, kMostCells));
  origin_ = low;
  const auto per_unit = [&](double extent) { return extent > 0 ? static_cast<double>(cells_) / extent : 0.0; };
  cells_per_unit_ = {per_unit(high.x - low.x), per_unit(high.y - low.y)};
  const auto cell_of = [&](uint32_t corner) {
    return row(points_[corner].y) * cells_ + column(points_[corner].x);
  };
  cell_begin_.assign(cells_ * cells_ + 1, 0);
  for (uint32_t i = 0; i < count; ++i)
    if (is_reflex_[i]) ++cell_begin_[cell_of(i) + 1];
  for (size_t cell = 0; cell < cells_ * cells_; ++cell) cell_begin_[cell + 1] += cell_begin_[cell];
  cell_corners_.resize(reflex_count);
  for (uint32_t i = count; i-- > 0;)
    if (is_reflex_[i]) cell_corners_[--cell_begin_[cell_of(i) + 1]] = i;
  // Filling backwards has moved each cell's end to its begin.
  cell_begin_.erase(cell_begin_.begin());
  cell_begin_.push_back(reflex_count);
}

void Triangulator::update_reflex(uint32_t corner) {
  if (is_reflex_[corner]) is_reflex_[corner] = turn(previous_[corner], corner, next_[corner]) <= 0;
}

// The outline of a region with holes follows a bridge twice, so corners may coincide.
bool Triangulator::holds(uint32_t a, uint32_t b, uint32_t c, uint32_t corner) const {
  if (corner == a || corner == b || corner == c) return false;
  const Point& p = points_[corner];
  for (const uint32_t own : {a, b, c})
    if (points_[own].x == p.x && points_[own].y == p.y) return false;
  return turn(a, b, corner) >= 0 && turn(b, c, corner) >= 0 && turn(c, a, corner) >= 0;
}

bool Triangulator::is_empty(uint32_t a, uint32_t b, uint32_t c) {
  const auto [left, right] = std::minmax({points_[a].x, points_[b].x, points_[c].x});
  const auto [low, high] = std::minmax({points_[a].y, points_[b].y, points_[c].y});
  const size_t first_column = column(left), last_column = column(right), last_row = row(high);
  for (size_t y = row(low); y <= last_row; ++y) {
    const uint32_t begin = cell_begin_[y * cells_ + first_column],
                   end = cell_begin_[y * cells_ + last_column + 1];
    steps_left_ -= std::min<uint64_t>(steps_left_, 1 + end - begin);
    for (uint32_t i = begin; i < end; ++i)
      if (is_reflex_[cell_corners_[i]] && holds(a, b, c, cell_corners_[i])) return false;
  }
  return true;
}

// Ear clipping: a triangle at a corner that turns left and that contains no other corner is cut off, until
// three corners are left. It is enough to test reflex corners. If there is no such triangle, the polygon
// crosses itself or has corners without area: then any corner is cut off, preferably one that turns left.
void Triangulator::cut_ears() {
  const auto count = static_cast<uint32_t>(points_.size());
  previous_.resize(count);
  next_.resize(count);
  for (uint32_t i = 0; i < count; ++i) {
    previous_[i] = i == 0 ? count - 1 : i - 1;
    next_[i] = i + 1 == count ? 0 : i + 1;
  }
  sort_reflex_corners();
  constexpr uint64_t kFreeSteps = 1'000'000, kStepsPerCorner = 500;
  steps_left_ = kFreeSteps + kStepsPerCorner * count;
  enum Choice { kEar, kFlat, kLeftTurn, kAny } choice = kEar;
  bool irregular = false;
  uint32_t corner = 0, tried = 0;
  for (uint32_t left = count; left > 3;) {
    const uint32_t before = previous_[corner], after = next_[corner];
    const double area = turn(before, corner, after);
    const bool cuts = choice == kEar        ? area > 0 && is_empty(before, corner, after)
                      : choice == kFlat     ? area == 0
                      : choice == kLeftTurn ? area > 0
                                            : true;
    if (!cuts) {
      corner = after;
      if (++tried < left && (choice != kEar || steps_left_ > 0)) continue;
      tried = 0;
      choice = static_cast<Choice>(choice + 1);
      continue;
    }
    irregular = irregular || choice > kFlat;
    triangles_.push_back({before, corner, after});
    next_[before] = after;
    previous_[after] = before;
    update_reflex(before);
    update_reflex(after);
    is_reflex_[corner] = 0;
    --left;
    tried = 0;
    choice = steps_left_ > 0 ? kEar : kLeftTurn;
    corner = next_[after];  // not the next corner, or all triangles would meet in one corner
  }
  triangles_.push_back({previous_[corner], corner, next_[corner]});
  irregular_count_ += irregular;
}

}  // namespace psplit
