#include "encoder/partition/partition.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "encoder/partition/clusters.h"
#include "encoder/partition/farthest_points.h"
#include "encoder/partition/refine_border.h"
#include "encoder/partition/topology.h"

namespace psplit {
namespace {

constexpr int kRelaxations = 7;

// Cuts one component into `count` patches, numbered from `base`.
void cut_component(const Topology& topology, const Component& component, uint32_t count, uint32_t base,
                   bool refine, std::vector<uint32_t>& patch_of_face) {
  Clusters clusters{patch_of_face, base, {}, {}, {}};
  std::vector<uint32_t> distance(topology.vertex_count());
  for (const uint32_t v : farthest_points(topology, component, count, distance))
    clusters.centres.push_back(topology.around(v).front());
  std::sort(clusters.centres.begin(), clusters.centres.end());
  clusters.centres.erase(std::unique(clusters.centres.begin(), clusters.centres.end()), clusters.centres.end());
  clusters.weights.assign(clusters.centres.size(), 0);
  assign_to_centres(topology, component, clusters);
  for (int i = 0; i < kRelaxations; ++i) {
    relax_centres(topology, component, clusters, i < 4 ? 0.4 : 0.25);
    assign_to_centres(topology, component, clusters);
  }
  if (refine) refine_border(topology, component, clusters);
}

// Numbers patches along a walk over their neighbours, so that neighbours get near numbers; none stays empty.
void renumber(const Topology& topology, Partition& partition) {
  std::vector<uint32_t>& patch_of = partition.patch_of_face;
  const uint32_t upper = *std::max_element(patch_of.begin(), patch_of.end()) + 1;
  std::vector<std::vector<uint32_t>> neighbours(upper);
  for (uint32_t v = 0; v < topology.vertex_count(); ++v)
    for (const uint32_t f : topology.around(v)) {
      const uint32_t a = patch_of[topology.around(v).front()], b = patch_of[f];
      if (a == b || (!neighbours[a].empty() && neighbours[a].back() == b)) continue;
      neighbours[a].push_back(b);
      neighbours[b].push_back(a);
    }
  std::vector<uint32_t> number(upper, kNoFace), queue;
  uint32_t next = 0;
  for (const uint32_t start : patch_of) {
    if (number[start] != kNoFace) continue;
    queue.assign(1, start);
    number[start] = next++;
    for (size_t i = 0; i < queue.size(); ++i)
      for (const uint32_t p : neighbours[queue[i]])
        if (number[p] == kNoFace) {
          number[p] = next++;
          queue.push_back(p);
        }
  }
  for (uint32_t& patch : patch_of) patch = number[patch];
  partition.patch_count = next;
}

}  // namespace

Partition partition_faces(std::span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count,
                          const PartitionOptions& options, const ThreadPool& pool) {
  Partition partition;
  partition.patch_of_face.assign(faces.size(), 0);
  if (faces.empty()) return partition;
  partition.patch_count = 1;
  const auto wanted = static_cast<uint32_t>(std::min<size_t>(options.patch_count, faces.size()));
  if (wanted <= 1) return partition;
  if (wanted == faces.size()) {
    std::iota(partition.patch_of_face.begin(), partition.patch_of_face.end(), 0u);
    partition.patch_count = wanted;
    return partition;
  }

  // Components get patches by their share of the faces; those of less than half a patch are packed together.
  const Topology topology(faces, vertex_count);
  const std::vector<Component> components = connected_components(topology);
  const double share = static_cast<double>(faces.size()) / wanted;
  uint32_t next = 0;
  double filled = 0;
  std::vector<std::pair<size_t, uint32_t>> large;  // component and the first of its patches
  for (const Component& component : components) {
    const auto size = static_cast<double>(component.faces.size());
    if (size >= share / 2) continue;
    if (filled > 0 && filled + size > share) {
      ++next;
      filled = 0;
    }
    for (const uint32_t f : component.faces) partition.patch_of_face[f] = next;
    filled += size;
  }
  if (filled > 0) ++next;
  const auto patches_of = [&](const Component& component) {
    return static_cast<uint32_t>(
        std::max(1L, std::lround(static_cast<double>(component.faces.size()) / share)));
  };
  for (size_t i = 0; i < components.size(); ++i) {
    if (static_cast<double>(components[i].faces.size()) < share / 2) continue;
    large.push_back({i, next});
    next += patches_of(components[i]);
  }
  pool.for_each(large.size(), [&](size_t i) {
    const Component& component = components[large[i].first];
    const uint32_t count = patches_of(component);
    if (count > 1)
      cut_component(topology, component, count, large[i].second, options.refine, partition.patch_of_face);
    else
      for (const uint32_t f : component.faces) partition.patch_of_face[f] = large[i].second;
  });
  renumber(topology, partition);
  return partition;
}

std::vector<uint32_t> distribute_patches(std::span<const uint64_t> face_counts, uint64_t patch_count) {
  const uint64_t total = std::accumulate(face_counts.begin(), face_counts.end(), uint64_t{0});
  std::vector<uint32_t> shares;
  for (const uint64_t faces : face_counts) {
    const auto exact = total == 0 ? 0.0L : static_cast<long double>(faces) * patch_count / total;
    shares.push_back(static_cast<uint32_t>(std::clamp(exact, 1.0L, 4294967295.0L)));
  }
  return shares;
}

}  // namespace psplit
