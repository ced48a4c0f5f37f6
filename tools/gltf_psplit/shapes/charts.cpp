#include "tools/gltf_psplit/shapes/charts.h"

#include <unordered_map>

namespace psplit {

Vec3 centre_of(const Surface& surface, const std::array<uint32_t, 3>& face) {
  Vec3 sum;
  for (const uint32_t vertex : face) {
    const std::array<float, 3>& p = surface.positions[vertex];
    sum = sum + Vec3{p[0], p[1], p[2]};
  }
  return sum * (1.0 / 3);
}

ChartedPoints unfold(Surface& surface, const Atlas& atlas) {
  const auto vertex_count = static_cast<uint32_t>(surface.positions.size());
  std::unordered_map<uint64_t, uint32_t> seam_points;
  ChartedPoints points;
  points.vertex.resize(vertex_count);
  points.chart.assign(vertex_count, kNoChart);
  points.texcoords.resize(vertex_count);
  for (std::array<uint32_t, 3>& face : surface.faces) {
    const uint8_t chart = atlas.chart(centre_of(surface, face));
    for (uint32_t& corner : face) {
      const uint32_t vertex = corner;
      if (points.chart[vertex] == chart) continue;
      const std::array<float, 2> texcoord = atlas.texcoord(chart, surface.positions[vertex]);
      if (points.chart[vertex] == kNoChart) {
        points.vertex[vertex] = vertex;
        points.chart[vertex] = chart;
        points.texcoords[vertex] = texcoord;
        continue;
      }
      const auto next = static_cast<uint32_t>(points.vertex.size());
      const auto [entry, is_new] = seam_points.try_emplace(uint64_t{vertex} * 256 + chart, next);
      if (is_new) {
        points.vertex.push_back(vertex);
        points.chart.push_back(chart);
        points.texcoords.push_back(texcoord);
      }
      corner = entry->second;
    }
  }
  return points;
}

}  // namespace psplit
