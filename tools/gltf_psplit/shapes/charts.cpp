#include "tools/gltf_psplit/shapes/charts.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace psplit {
namespace {

constexpr uint8_t kNoChart = 255;

struct Projection {
  bool closed;
  Vec3 low, high;  // bounds of the surface, which may extend a little beyond the field's box

  Projection(const Surface& surface, const Field& field)
      : closed(field.closed), low(field.high), high(field.low) {
    for (const auto& [x, y, z] : surface.positions) {
      low = {std::min<double>(low.x, x), std::min<double>(low.y, y), std::min<double>(low.z, z)};
      high = {std::max<double>(high.x, x), std::max<double>(high.y, y), std::max<double>(high.z, z)};
    }
  }

  uint8_t chart(Vec3 p) const {
    const Vec3 d = p - (low + high) * 0.5;
    if (!closed) {
      const double third = (high.x - low.x) / 6;
      const uint8_t column = d.x < -third ? 0 : d.x < third ? 1 : 2;
      return static_cast<uint8_t>(column + (d.z < 0 ? 0 : 3));
    }
    const double x = std::fabs(d.x), y = std::fabs(d.y), z = std::fabs(d.z);
    if (x >= y && x >= z) return d.x < 0 ? 0 : 1;
    if (y >= z) return d.y < 0 ? 2 : 3;
    return d.z < 0 ? 4 : 5;
  }

  // Each chart is one side of the box, shrunk a little, in one cell of a 3 x 2 atlas.
  std::array<float, 2> texcoord(uint8_t chart_index, const std::array<float, 3>& p) const {
    const auto part = [](double value, double from, double to) {
      return 0.02 + 0.96 * (value - from) / (to - from);
    };
    const double x = part(p[0], low.x, high.x);
    const double y = part(p[1], low.y, high.y);
    const double z = part(p[2], low.z, high.z);
    const int side = closed ? chart_index / 2 : 1;
    const double u = side == 0 ? z : x;
    const double v = side == 1 ? z : y;
    return {static_cast<float>((chart_index % 3 + u) / 3), static_cast<float>((chart_index / 3 + v) / 2)};
  }
};

}  // namespace

ChartedPoints unfold(Surface& surface, const Field& field) {
  const Projection projection(surface, field);
  const auto vertex_count = static_cast<uint32_t>(surface.positions.size());
  std::vector<uint8_t> first_chart(vertex_count, kNoChart);
  std::unordered_map<uint64_t, uint32_t> seam_points;
  ChartedPoints points;
  points.vertex.resize(vertex_count);
  points.texcoords.resize(vertex_count);
  for (std::array<uint32_t, 3>& face : surface.faces) {
    Vec3 sum;
    for (const uint32_t vertex : face) {
      const std::array<float, 3>& p = surface.positions[vertex];
      sum = sum + Vec3{p[0], p[1], p[2]};
    }
    const uint8_t chart = projection.chart(sum * (1.0 / 3));
    for (uint32_t& corner : face) {
      const uint32_t vertex = corner;
      if (first_chart[vertex] == chart) continue;
      const std::array<float, 2> texcoord = projection.texcoord(chart, surface.positions[vertex]);
      if (first_chart[vertex] == kNoChart) {
        first_chart[vertex] = chart;
        points.vertex[vertex] = vertex;
        points.texcoords[vertex] = texcoord;
        continue;
      }
      const auto next = static_cast<uint32_t>(points.vertex.size());
      const auto [entry, is_new] = seam_points.try_emplace(uint64_t{vertex} * 8 + chart, next);
      if (is_new) {
        points.vertex.push_back(vertex);
        points.texcoords.push_back(texcoord);
      }
      corner = entry->second;
    }
  }
  return points;
}

}  // namespace psplit
