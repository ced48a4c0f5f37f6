// Edge functions in fixed point: Pineda, "A Parallel Algorithm for Polygon Rasterization" (1988). Centres on an
// edge follow the rule of graphics APIs: they belong to the triangle if it is a top or left edge.
#include "tools/gltf_psplit/preview/visibility.h"

#include <algorithm>
#include <cmath>

namespace psplit {
namespace {

constexpr int64_t kUnit = 256;                    // fixed-point units from one sample to the next
constexpr double kFarOutside = int64_t{1} << 20;  // in samples; products of differences stay below 2^60
constexpr double kNearest = 4294967295.0;         // 2^32 - 1

// An edge of a triangle that is clockwise on the screen, where y points down.
struct Edge {
  int64_t dx, dy, at_origin;
  int64_t least;  // the smallest value at a centre that counts as inside

  Edge(int64_t from_x, int64_t from_y, int64_t to_x, int64_t to_y)
      : dx(to_x - from_x), dy(to_y - from_y), at_origin(dy * from_x - dx * from_y) {
    const bool top_or_left = dy < 0 || (dy == 0 && dx > 0);
    least = top_or_left ? 0 : 1;
  }
  // Twice the area between the edge and the point.
  int64_t value(int64_t x, int64_t y) const { return dx * y - dy * x + at_origin; }
};

}  // namespace

void VisibilityBuffer::draw(const std::array<ScreenPoint, 3>& corners, uint32_t face) {
  std::array<int64_t, 3> x{}, y{};
  for (size_t i = 0; i < 3; ++i) {
    // Also false for a coordinate that is not a number.
    if (!(std::abs(corners[i].x) < kFarOutside && std::abs(corners[i].y) < kFarOutside)) return;
    x[i] = std::llround(corners[i].x * kUnit);
    y[i] = std::llround(corners[i].y * kUnit);
  }
  const int64_t area = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]);
  if (area == 0) return;
  const size_t b = area > 0 ? 1 : 2, c = 3 - b;
  const Edge ab(x[0], y[0], x[b], y[b]), bc(x[b], y[b], x[c], y[c]), ca(x[c], y[c], x[0], y[0]);
  const double nearness_a = corners[0].nearness, per_area = 1 / static_cast<double>(std::abs(area));
  const double step_b = (corners[b].nearness - nearness_a) * per_area;
  const double step_c = (corners[c].nearness - nearness_a) * per_area;

  const auto [low_x, high_x] = std::minmax({x[0], x[1], x[2]});
  const auto [low_y, high_y] = std::minmax({y[0], y[1], y[2]});
  const auto first = [](int64_t low) { return std::max<int64_t>(low, 0) / kUnit; };
  const auto end = [](int64_t high, int count) { return std::min<int64_t>(high / kUnit + 1, count); };
  for (int64_t row = first(low_y); row < end(high_y, size_.height); ++row)
    for (int64_t column = first(low_x); column < end(high_x, size_.width); ++column) {
      const int64_t centre_x = column * kUnit + kUnit / 2, centre_y = row * kUnit + kUnit / 2;
      const int64_t of_b = ca.value(centre_x, centre_y), of_c = ab.value(centre_x, centre_y);
      if (of_b < ca.least || of_c < ab.least || bc.value(centre_x, centre_y) < bc.least) continue;
      const double nearness =
          nearness_a + static_cast<double>(of_b) * step_b + static_cast<double>(of_c) * step_c;
      const auto level = static_cast<uint64_t>(std::clamp(nearness, 0.0, 1.0) * kNearest);
      const uint64_t mark = level << 32 | (kNoFace - face);
      std::atomic<uint64_t>& sample = samples_[index(static_cast<int>(column), static_cast<int>(row))];
      uint64_t seen = sample.load(std::memory_order_relaxed);
      while (seen < mark && !sample.compare_exchange_weak(seen, mark, std::memory_order_relaxed)) {
      }
    }
}

}  // namespace psplit
