// A camera that has the whole object in its picture.
#pragma once

#include <array>

#include "tools/gltf_psplit/shapes/vec3.h"

namespace psplit {

struct ImageSize {
  int width = 1200, height = 900;
};

// Where a point of the world appears: x to the right and y down, in pixels; 1 is nearest, 0 is farthest, and
// what lies between is linear along lines of the picture.
struct ScreenPoint {
  double x = 0, y = 0, nearness = 0;
};

struct Camera {
  Vec3 right, up, back;  // back points from the object to the eye
  Vec3 eye;
  double focal = 1, centre_x = 0, centre_y = 0;  // in pixels
  double farthest = 0, nearness_scale = 1;       // of 1 / depth

  ScreenPoint project(Vec3 world) const {
    const Vec3 d = world - eye;
    const double inverse_depth = -1 / dot(back, d);
    return {centre_x + focal * dot(right, d) * inverse_depth, centre_y - focal * dot(up, d) * inverse_depth,
            (inverse_depth - farthest) * nearness_scale};
  }
};

// Collects what must be seen, in any order and with the same result: points add up to a frame by maxima.
class Framing {
 public:
  explicit Framing(ImageSize size);
  void add(Vec3 point);
  void add(const Framing& other);
  // The front, from the right and above, with a margin. Without a point nothing is to be seen.
  Camera camera() const;

 private:
  // The camera, looking along -z of its own axes, sees a point p where |p.x - eye.x| <= slope_x (eye.z - p.z),
  // and the same of y: four half-spaces, each as far out as one point pushes it.
  Camera axes_;
  ImageSize size_;
  double slope_x_, slope_y_;  // half the width and height of the field of view at distance 1, without margin
  std::array<double, 4> reach_;
  double low_z_, high_z_;
};

}  // namespace psplit
