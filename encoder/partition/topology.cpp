#include "encoder/partition/topology.h"

#include <numeric>
#include <utility>

namespace psplit {

Topology::Topology(std::span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count)
    : faces_(faces), first_(size_t{vertex_count} + 1), around_(faces.size() * 3) {
  for (const auto& face : faces)
    for (const uint32_t v : face) ++first_[v + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
  for (uint32_t i = 0; i < faces.size(); ++i)
    for (const uint32_t v : faces[i]) around_[next[v]++] = i;
}

std::vector<Component> connected_components(const Topology& topology) {
  const auto faces = topology.faces();
  std::vector<uint8_t> face_seen(faces.size(), 0), vertex_seen(topology.vertex_count(), 0);
  std::vector<Component> components;
  for (uint32_t start = 0; start < faces.size(); ++start) {
    if (std::exchange(face_seen[start], uint8_t{1}) != 0) continue;
    Component& component = components.emplace_back();
    component.faces.push_back(start);
    for (size_t i = 0; i < component.faces.size(); ++i)
      for (const uint32_t v : faces[component.faces[i]]) {
        if (std::exchange(vertex_seen[v], uint8_t{1}) != 0) continue;
        component.vertices.push_back(v);
        for (const uint32_t g : topology.around(v))
          if (std::exchange(face_seen[g], uint8_t{1}) == 0) component.faces.push_back(g);
      }
  }
  return components;
}

}  // namespace psplit
