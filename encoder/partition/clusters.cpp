#include "encoder/partition/clusters.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace psplit {
namespace {

constexpr uint32_t kStep = 4;

}  // namespace

void assign_to_centres(const Topology& topology, const Component& component, Clusters& clusters) {
  const auto patch_count = static_cast<uint32_t>(clusters.centres.size());
  std::vector<uint32_t>& patch_of = clusters.patch_of_face;
  for (const uint32_t f : component.faces) patch_of[f] = kNoFace;
  std::vector<uint8_t> reached(topology.vertex_count(), 0);

  // All steps cost the same, so the first to reach a face is the nearest; one queue per distance keeps the
  // order.
  std::vector<std::vector<uint32_t>> queues;
  const auto push = [&](uint32_t distance, uint32_t face) {
    if (distance >= queues.size()) queues.resize(size_t{distance} + 1);
    queues[distance].push_back(face);
  };
  for (uint32_t p = 0; p < patch_count; ++p) {
    patch_of[clusters.centres[p]] = clusters.base + p;
    push(clusters.weights[p], clusters.centres[p]);
  }
  clusters.sizes.assign(patch_count, 0);
  for (uint32_t d = 0; d < queues.size(); ++d) {
    const std::vector<uint32_t> queue = std::exchange(queues[d], {});
    for (const uint32_t f : queue) {
      ++clusters.sizes[patch_of[f] - clusters.base];
      for (const uint32_t v : topology.faces()[f]) {
        if (std::exchange(reached[v], uint8_t{1}) != 0) continue;
        for (const uint32_t g : topology.around(v))
          if (patch_of[g] == kNoFace) {
            patch_of[g] = patch_of[f];
            push(d + kStep, g);
          }
      }
    }
  }
}

void relax_centres(const Topology& topology, const Component& component, Clusters& clusters, double gain) {
  const auto patch_count = static_cast<uint32_t>(clusters.centres.size());
  const std::vector<uint32_t>& patch_of = clusters.patch_of_face;
  // Waves run inwards from all borders at once; the last face that one reaches in a patch is the deepest.
  std::vector<uint8_t> reached(topology.vertex_count(), 0), visited(topology.faces().size(), 0);
  std::vector<uint32_t> front, next;
  for (const uint32_t v : component.vertices) {
    const auto around = topology.around(v);
    const uint32_t patch = patch_of[around.front()];
    if (std::all_of(around.begin(), around.end(), [&](uint32_t f) { return patch_of[f] == patch; })) continue;
    reached[v] = 1;
    for (const uint32_t f : around)
      if (std::exchange(visited[f], uint8_t{1}) == 0) front.push_back(f);
  }
  std::vector<std::pair<uint32_t, uint32_t>> deepest(patch_count, {0, kNoFace});
  for (uint32_t depth = 1; !front.empty(); ++depth) {
    next.clear();
    for (const uint32_t f : front) {
      auto& best = deepest[patch_of[f] - clusters.base];
      if (best.first < depth) best = {depth, f};
      for (const uint32_t v : topology.faces()[f]) {
        if (std::exchange(reached[v], uint8_t{1}) != 0) continue;
        for (const uint32_t g : topology.around(v))
          if (std::exchange(visited[g], uint8_t{1}) == 0) next.push_back(g);
      }
    }
    std::swap(front, next);
  }

  // A patch of n times its share reaches sqrt(n) times as far as it should.
  const double mean = static_cast<double>(component.faces.size()) / patch_count;
  const double radius = kStep * std::sqrt(mean / 6.0);
  std::vector<double> wanted(patch_count);
  for (uint32_t p = 0; p < patch_count; ++p) {
    if (deepest[p].second != kNoFace) clusters.centres[p] = deepest[p].second;
    wanted[p] = clusters.weights[p] + gain * radius * std::min(std::sqrt(clusters.sizes[p] / mean) - 1.0, 1.0);
  }
  const double lowest = *std::min_element(wanted.begin(), wanted.end());
  for (uint32_t p = 0; p < patch_count; ++p)
    clusters.weights[p] = static_cast<uint32_t>(std::lround(std::min(wanted[p] - lowest, 4 * radius)));
}

}  // namespace psplit
