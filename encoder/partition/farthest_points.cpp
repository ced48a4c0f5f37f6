#include "encoder/partition/farthest_points.h"

#include <utility>

namespace psplit {

std::vector<uint32_t> farthest_points(const Topology& topology, const Component& component, uint32_t count,
                                      std::vector<uint32_t>& distance) {
  for (const uint32_t v : component.vertices) distance[v] = 0xffffffffu;
  // Vertices by distance; an entry is stale when its vertex has come nearer since.
  std::vector<std::vector<uint32_t>> by_distance;
  const auto farthest = [&]() -> uint32_t {
    for (; !by_distance.empty(); by_distance.pop_back())
      for (std::vector<uint32_t>& bucket = by_distance.back(); !bucket.empty(); bucket.pop_back())
        if (distance[bucket.back()] + 1 == by_distance.size()) return bucket.back();
    return kNoFace;
  };

  std::vector<uint32_t> samples, front, next;
  uint32_t sample = component.vertices.front();
  while (samples.size() < count && sample != kNoFace) {
    samples.push_back(sample);
    distance[sample] = 0;
    front.assign(1, sample);
    for (uint32_t d = 1; !front.empty(); ++d) {
      next.clear();
      for (const uint32_t v : front)
        for (const uint32_t face : topology.around(v))
          for (const uint32_t w : topology.faces()[face]) {
            if (distance[w] <= d) continue;
            distance[w] = d;
            next.push_back(w);
          }
      if (by_distance.size() <= d && !next.empty()) by_distance.resize(size_t{d} + 1);
      if (!next.empty()) by_distance[d].insert(by_distance[d].end(), next.begin(), next.end());
      std::swap(front, next);
    }
    sample = farthest();
  }
  return samples;
}

}  // namespace psplit
