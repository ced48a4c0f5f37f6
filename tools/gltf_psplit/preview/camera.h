// A camera whose picture contains the whole object.
#pragma once

#include <array>

#include "tools/gltf_psplit/shapes/vec3.h"

namespace psplit {

struct ImageSize {
  int width = 1200, height = 900;
};

// A point on the screen. x (to the right) and y (down) are in pixels. Nearness is 1 for the nearest and 0 for
// the farthest point, and linear along lines on the screen.
struct ScreenPoint {
  double x = 0, y = 0, nearness = 0;
};

struct Camera {
  Vec3 right, up, back;  // back points from the object to the eye
  Vec3 eye;
  double focal = 1, centre_x = 0, centre_y = 0;  // in pixels
  double farthest = 0, nearness_scale = 1;       // for 1 / depth

  ScreenPoint project(Vec3 world) const {
    const Vec3 d = world - eye;
    const double inverse_depth = -1 / dot(back, d);
    return {centre_x + focal * dot(right, d) * inverse_depth, centre_y - focal * dot(up, d) * inverse_depth,
            (inverse_depth - farthest) * nearness_scale};
  }
};

// Collects the points that must be visible. Their order does not matter, because only maxima are kept.
class Framing {
 public:
  explicit Framing(ImageSize size);
  void add(Vec3 point);
  void add(const Framing& other);
  // A camera that looks at the front from the right and above, with a margin around all points. Add a point
  // first.
  Camera camera() const;

 private:
  // The camera looks along -z of its own axes. It sees a point p if |p.x - eye.x| <= slope_x (eye.z - p.z), and
  // likewise for y. These are four half-spaces; the points push each of them outwards.
  Camera axes_;
  double slope_x_, slope_y_;  // half the width and height of the field of view at distance 1, without margin
  std::array<double, 4> reach_;
  double low_z_, high_z_;
};

}  // namespace psplit
