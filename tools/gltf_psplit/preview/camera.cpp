#include "tools/gltf_psplit/preview/camera.h"

#include <algorithm>
#include <limits>
#include <numbers>

namespace psplit {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kFromTheRight = 35 * kDegree, kFromAbove = 22 * kDegree;
constexpr double kHalfFieldOfView = 13 * kDegree;  // for the shorter side
constexpr double kMargin = 0.05;                   // share of the picture, on every side
constexpr double kNone = std::numeric_limits<double>::lowest();

}  // namespace

Framing::Framing(ImageSize size) : low_z_(-kNone), high_z_(kNone) {
  axes_.right = {std::cos(kFromTheRight), 0, -std::sin(kFromTheRight)};
  axes_.back = Vec3{std::sin(kFromTheRight), 0, std::cos(kFromTheRight)} * std::cos(kFromAbove) +
               Vec3{0, std::sin(kFromAbove), 0};
  axes_.up = cross(axes_.back, axes_.right);
  axes_.focal = 0.5 * std::min(size.width, size.height) / std::tan(kHalfFieldOfView);
  axes_.centre_x = 0.5 * size.width;
  axes_.centre_y = 0.5 * size.height;
  slope_x_ = axes_.centre_x * (1 - 2 * kMargin) / axes_.focal;
  slope_y_ = axes_.centre_y * (1 - 2 * kMargin) / axes_.focal;
  reach_.fill(kNone);
}

void Framing::add(Vec3 point) {
  const double x = dot(axes_.right, point), y = dot(axes_.up, point), z = dot(axes_.back, point);
  const std::array<double, 4> reach{slope_x_ * z + x, slope_x_ * z - x, slope_y_ * z + y, slope_y_ * z - y};
  for (size_t i = 0; i < reach.size(); ++i) reach_[i] = std::max(reach_[i], reach[i]);
  low_z_ = std::min(low_z_, z);
  high_z_ = std::max(high_z_, z);
}

void Framing::add(const Framing& other) {
  for (size_t i = 0; i < reach_.size(); ++i) reach_[i] = std::max(reach_[i], other.reach_[i]);
  low_z_ = std::min(low_z_, other.low_z_);
  high_z_ = std::max(high_z_, other.high_z_);
}

Camera Framing::camera() const {
  const auto [right, left, top, bottom] = reach_;
  // As near as both directions allow, but not so near that the perspective becomes steep or the depth
  // imprecise.
  const double z = std::max(
      {(right + left) / (2 * slope_x_), (top + bottom) / (2 * slope_y_), high_z_ + (high_z_ - low_z_)});
  Camera camera = axes_;
  camera.eye = axes_.right * ((right - left) / 2) + axes_.up * ((top - bottom) / 2) + axes_.back * z;
  camera.farthest = 1 / (z - low_z_);
  const double range = 1 / (z - high_z_) - camera.farthest;
  camera.nearness_scale = range > 0 ? 1 / range : 0;
  return camera;
}

}  // namespace psplit
