// Polygons of any size to triangles.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace psplit {

using Position = std::array<float, 3>;
using PrecisePosition = std::array<double, 3>;  // as a file states it
using Triangle = std::array<uint32_t, 3>;

// Its memory is reused from one polygon to the next.
class Triangulator {
 public:
  // Cuts a polygon of n >= 3 corners into n - 2 triangles of corner numbers. They have the orientation of the
  // polygon and use every corner. They cover the polygon exactly if it is flat, or nearly flat, and does not
  // cross itself. It may be concave and may have corners on straight edges. Convex polygons become fans around
  // corner 0. Positions must be finite. The triangles are valid until the next call. Time grows with n, also
  // for hostile polygons.
  std::span<const Triangle> triangulate(std::span<const PrecisePosition> polygon);

  // The number of polygons so far that could not be covered, because they cross themselves or have no area.
  uint64_t irregular_count() const { return irregular_count_; }

 private:
  struct Point {
    double x, y;
  };
  // Projects the polygon to a plane: points_ are its corners there, counterclockwise. False if there is no
  // plane.
  bool project(std::span<const PrecisePosition> polygon);
  bool is_strictly_convex() const;
  double turn(uint32_t a, uint32_t b, uint32_t c) const;  // twice the area of a triangle of points_
  void fan(size_t corner_count);
  void cut_quad();
  void cut_ears();
  void sort_reflex_corners();
  void update_reflex(uint32_t corner);
  bool is_empty(uint32_t a, uint32_t b, uint32_t c);  // whether no reflex corner is in the triangle
  bool holds(uint32_t a, uint32_t b, uint32_t c, uint32_t corner) const;
  size_t column(double x) const;
  size_t row(double y) const;

  std::vector<Triangle> triangles_;
  std::vector<Point> points_;
  std::vector<uint32_t> previous_, next_;
  std::vector<uint8_t> is_reflex_;
  // The reflex corners, by the cells of a grid over the polygon.
  std::vector<uint32_t> cell_begin_, cell_corners_;
  size_t cells_ = 1;  // along each axis
  Point origin_{}, cells_per_unit_{};
  uint64_t steps_left_ = 0;
  uint64_t irregular_count_ = 0;
};

}  // namespace psplit
