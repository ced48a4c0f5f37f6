// Source: Kimmel, Sethian: Computing Geodesic Paths on Manifolds, 1998; here all triangles are equilateral.
#include "encoder/partition/path_distance.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace psplit {
namespace {

constexpr uint32_t kFarthest = kUnreached - 1;  // the length of all longer paths: their faces are reached
constexpr uint32_t kSteepest = kEdgeLength / 2;

// A straight front that reaches two vertices at u and u + d reaches the third at u + kCrossing[d], unless it
// comes from beyond the first vertex. In a triangle with sides 1 this is (d + sqrt(3 (1 - d^2))) / 2, up to d =
// 1/2. A front that reaches one of the two later does not reach the third earlier, and the third is always the
// last. So distances depend only on the sources, not on the order in which they were added.
constexpr std::array<uint32_t, kSteepest + 1> kCrossing = [] {
  std::array<uint32_t, kSteepest + 1> crossing{};
  for (uint32_t d = 0; d <= kSteepest; ++d) {
    uint32_t& last = crossing[d] = d;
    while ((2 * last + 1 - d) * (2 * last + 1 - d) <= 3 * (kEdgeLength * kEdgeLength - d * d)) ++last;
  }
  return crossing;
}();

}  // namespace

DistanceMap::DistanceMap(std::span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count,
                         const FaceGraph& graph, PathDistance kind)
    : faces_(faces),
      vertex_count_(vertex_count),
      graph_(graph),
      kind_(kind),
      first_corner_(size_t{vertex_count} + 1),
      corners_(faces.size() * 3),
      reaches_(vertex_count + faces.size()) {
  for (const auto& face : faces)
    for (const uint32_t v : face) ++first_corner_[v];
  std::partial_sum(first_corner_.begin(), first_corner_.end(), first_corner_.begin());
  for (size_t f = faces.size(); f-- > 0;) {
    const auto& [a, b, c] = faces[f];
    const auto face = static_cast<uint32_t>(f);
    corners_[--first_corner_[a]] = {face, b, c};
    corners_[--first_corner_[b]] = {face, c, a};
    corners_[--first_corner_[c]] = {face, a, b};
  }
}

void DistanceMap::clear() { std::fill(reaches_.begin(), reaches_.end(), Reach{}); }

void DistanceMap::add(std::span<const Source> sources) {
  size_t added = 0;
  for (uint32_t here = sources.empty() ? 0 : sources[0].start; front_count_ > 0 || added < sources.size();
       ++here) {
    for (; added < sources.size() && sources[added].start <= here; ++added) {
      const Source& source = sources[added];
      Reach& centre = reaches_[vertex_count_ + source.face];
      if (here >= centre.distance) continue;
      centre = {here, source.number};
      expand_face(source.face);
    }
    std::vector<uint32_t>& bucket = buckets_[here % kBuckets];
    for (size_t i = 0; i < bucket.size(); ++i) {
      const uint32_t node = bucket[i];
      if (reaches_[node].distance != here) continue;  // a shorter path was found since
      if (node >= vertex_count_)
        expand_face(node - vertex_count_);
      else if (kind_ == PathDistance::kDijkstra)
        expand_vertex(node);
      else
        march(node);
    }
    front_count_ -= bucket.size();
    bucket.clear();
  }
}

uint32_t DistanceMap::distance(uint32_t face) const {
  const uint32_t at_centre = reaches_[vertex_count_ + face].distance;
  if (kind_ == PathDistance::kDijkstra) return at_centre;
  uint64_t sum = 0;
  for (const uint32_t v : faces_[face]) sum += reaches_[v].distance;
  return std::min(at_centre, static_cast<uint32_t>(sum / 3));  // when a straight front passes the centre
}

uint32_t DistanceMap::nearest(uint32_t face) const {
  const Reach* nearest = &reaches_[vertex_count_ + face];
  if (kind_ == PathDistance::kGeodesic)
    for (const uint32_t v : faces_[face])
      if (reaches_[v].distance < nearest->distance) nearest = &reaches_[v];
  return nearest->number;
}

inline void DistanceMap::reach(uint32_t node, uint64_t distance, uint32_t number) {
  const auto there = static_cast<uint32_t>(std::min<uint64_t>(distance, kFarthest));
  if (there >= reaches_[node].distance) return;
  reaches_[node] = {there, number};
  buckets_[there % kBuckets].push_back(node);
  ++front_count_;
}

void DistanceMap::expand_face(uint32_t face) {
  const Reach here = reaches_[vertex_count_ + face];
  for (const uint32_t v : faces_[face]) reach(v, uint64_t{here.distance} + kSpokeLength, here.number);
  if (kind_ == PathDistance::kGeodesic) return;
  graph_.for_each_link(face, [&](uint32_t other, uint32_t) {
    reach(vertex_count_ + other, uint64_t{here.distance} + kSpokeLength, here.number);
  });
}

void DistanceMap::expand_vertex(uint32_t vertex) {
  const Reach here = reaches_[vertex];
  for (uint32_t i = first_corner_[vertex]; i < first_corner_[vertex + 1]; ++i) {
    const Corner& corner = corners_[i];
    reach(vertex_count_ + corner.face, uint64_t{here.distance} + kSpokeLength, here.number);
    for (const uint32_t v : {corner.left, corner.right})
      reach(v, uint64_t{here.distance} + kEdgeLength, here.number);
  }
}

void DistanceMap::march(uint32_t vertex) {
  const Reach here = reaches_[vertex];
  const auto cross = [&](uint32_t beside, uint32_t to) {
    if (reaches_[to].distance <= here.distance) return;
    const auto [near, far] = std::minmax(here.distance, reaches_[beside].distance);
    const uint32_t d = far - near;
    reach(to, uint64_t{near} + (d > kSteepest ? kEdgeLength : kCrossing[d]), here.number);
  };
  for (uint32_t i = first_corner_[vertex]; i < first_corner_[vertex + 1]; ++i) {
    cross(corners_[i].left, corners_[i].right);
    cross(corners_[i].right, corners_[i].left);
  }
}

}  // namespace psplit
