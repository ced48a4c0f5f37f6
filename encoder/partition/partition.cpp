#include "encoder/partition/partition.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace psplit {
namespace {

constexpr uint32_t kNone = 0xffffffffu;
constexpr double kPull = 60.0;
constexpr uint32_t kHop = 4;  // cost of one step from face to vertex to face: weights move in quarters of it

using FaceSpan = std::span<const std::array<uint32_t, 3>>;

struct Topology {
  FaceSpan faces;
  std::vector<uint32_t> first, around;          // faces around each vertex
  std::vector<uint32_t> edge_first, neighbour;  // faces across edges

  Topology(FaceSpan f, uint32_t vertex_count)
      : faces(f), first(size_t{vertex_count} + 1), around(f.size() * 3) {
    for (const auto& face : faces)
      for (uint32_t v : face) ++first[v + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<uint32_t> next(first.begin(), first.end() - 1);
    for (uint32_t i = 0; i < faces.size(); ++i)
      for (uint32_t v : faces[i]) around[next[v]++] = i;
    edge_first.resize(faces.size() + 1);
    neighbour.reserve(faces.size() * 3);
    for (uint32_t i = 0; i < faces.size(); ++i) {
      for (size_t c = 0; c < 3; ++c) add_across(i, faces[i][c], faces[i][(c + 1) % 3]);
      edge_first[i + 1] = static_cast<uint32_t>(neighbour.size());
    }
  }

  std::span<const uint32_t> around_vertex(uint32_t v) const {
    return std::span(around).subspan(first[v], first[v + 1] - first[v]);
  }
  std::span<const uint32_t> across_edges(uint32_t f) const {
    return std::span(neighbour).subspan(edge_first[f], edge_first[f + 1] - edge_first[f]);
  }

 private:
  void add_across(uint32_t face, uint32_t a, uint32_t b) {
    if (first[a + 1] - first[a] > first[b + 1] - first[b]) std::swap(a, b);
    // A hub of many spokes would make every spoke walk them all.
    for (uint32_t other : around_vertex(a)) {
      const auto& o = faces[other];
      if (other != face && (o[0] == b || o[1] == b || o[2] == b)) neighbour.push_back(other);
    }
  }
};

// A queue of faces by distance, served in order of distance and, at one distance, of arrival.
class BucketQueue {
 public:
  void push(uint32_t distance, uint32_t face) {
    if (distance >= buckets_.size()) buckets_.resize(distance + 1);
    buckets_[distance].push_back(face);
  }
  template <typename Visit>
  void drain(Visit visit) {
    for (uint32_t d = 0; d < buckets_.size(); ++d) {
      for (size_t i = 0; i < buckets_[d].size(); ++i) visit(d, buckets_[d][i]);
      buckets_[d].clear();
    }
  }

 private:
  std::vector<std::vector<uint32_t>> buckets_;
};

class Component {
 public:
  Component(const Topology& topology, std::vector<uint32_t> members, uint32_t patches,
            std::vector<uint32_t>& patch_of)
      : topology_(topology), members_(std::move(members)), patch_count_(patches), patch_of_(patch_of) {}

  void cut(uint32_t first_patch, bool refine, std::vector<uint32_t>& distance, std::vector<uint32_t>& stamp) {
    base_ = first_patch;
    distance_ = &distance;
    stamp_ = &stamp;
    if (patch_count_ <= 1) {
      for (uint32_t f : members_) patch_of_[f] = base_;
      return;
    }
    sample_centres();
    weights_.assign(patch_count_, 0);
    for (int i = 0; i < 9; ++i) {
      assign();
      if (i < 8) relax(i);
    }
    if (refine) {
      straighten();
      smooth();
    }
  }

 private:
  void sample_centres() {
    std::vector<uint32_t>& distance = *distance_;
    for (uint32_t f : members_) distance[f] = kNone;
    std::vector<std::vector<uint32_t>> farthest;
    std::vector<uint32_t> front, next;
    uint32_t centre = members_[0];
    for (uint32_t k = 0; k < patch_count_; ++k) {
      if (k > 0) {
        while (!farthest.empty()) {
          if (farthest.back().empty()) {
            farthest.pop_back();
            continue;
          }
          centre = farthest.back().back();
          if (distance[centre] + 1 == farthest.size() && distance[centre] > 0) break;
          farthest.back().pop_back();
        }
      }
      centres_.push_back(centre);
      distance[centre] = 0;
      front = {centre};
      for (uint32_t d = 1; !front.empty(); ++d) {
        next.clear();
        for (uint32_t f : front)
          for (uint32_t v : topology_.faces[f])
            for (uint32_t g : topology_.around_vertex(v))
              if (distance[g] > d) {
                distance[g] = d;
                next.push_back(g);
                if (d >= farthest.size()) farthest.resize(d + 1);
                farthest[d].push_back(g);
              }
        std::swap(front, next);
      }
    }
    std::sort(centres_.begin(), centres_.end());
    centres_.erase(std::unique(centres_.begin(), centres_.end()), centres_.end());
    patch_count_ = static_cast<uint32_t>(centres_.size());
  }

  void assign() {
    for (uint32_t f : members_) {
      patch_of_[f] = kNone;
      for (uint32_t v : topology_.faces[f]) (*stamp_)[v] = 0;
    }
    BucketQueue queue;
    for (uint32_t p = 0; p < patch_count_; ++p) {
      patch_of_[centres_[p]] = p;
      queue.push(weights_[p], centres_[p]);
    }
    sizes_.assign(patch_count_, 0);
    queue.drain([&](uint32_t d, uint32_t f) {
      ++sizes_[patch_of_[f]];
      for (uint32_t v : topology_.faces[f]) {
        if ((*stamp_)[v]) continue;
        (*stamp_)[v] = 1;
        for (uint32_t g : topology_.around_vertex(v))
          if (patch_of_[g] == kNone) {
            patch_of_[g] = patch_of_[f];
            queue.push(d + kHop, g);
          }
      }
    });
    for (uint32_t f : members_) patch_of_[f] += base_;
  }

  void relax(int round) {
    // The new centre is the face deepest inside.
    std::vector<uint32_t>& distance = *distance_;
    std::vector<uint32_t> front, next;
    for (uint32_t f : members_) {
      distance[f] = kNone;
      for (uint32_t v : topology_.faces[f]) (*stamp_)[v] = 0;
    }
    for (uint32_t f : members_)
      for (uint32_t v : topology_.faces[f]) {
        for (uint32_t g : topology_.around_vertex(v))
          if (patch_of_[g] != patch_of_[f]) {
            distance[f] = 0;
            break;
          }
        if (distance[f] == 0) break;
      }
    for (uint32_t f : members_)
      if (distance[f] == 0) front.push_back(f);
    std::vector<uint32_t> deepest(patch_count_, kNone);
    for (uint32_t d = 1; !front.empty(); ++d) {
      next.clear();
      for (uint32_t f : front) {
        uint32_t& best = deepest[patch_of_[f] - base_];
        if (best == kNone || distance[best] < distance[f]) best = f;
        for (uint32_t v : topology_.faces[f]) {
          if ((*stamp_)[v]) continue;
          (*stamp_)[v] = 1;
          for (uint32_t g : topology_.around_vertex(v))
            if (distance[g] == kNone) {
              distance[g] = d;
              next.push_back(g);
            }
        }
      }
      std::swap(front, next);
    }
    const double mean = static_cast<double>(members_.size()) / patch_count_;
    const double radius = kHop * std::sqrt(mean / 6.0);
    std::vector<double> wanted(patch_count_);
    for (uint32_t p = 0; p < patch_count_; ++p) {
      if (deepest[p] != kNone) centres_[p] = deepest[p];
      const double excess = std::sqrt(sizes_[p] / mean) - 1.0;
      wanted[p] = weights_[p] + (round < 4 ? 0.5 : 0.8) * radius * std::min(excess, 1.0);
    }
    const double lowest = *std::min_element(wanted.begin(), wanted.end());
    for (uint32_t p = 0; p < patch_count_; ++p)
      weights_[p] = static_cast<uint32_t>(std::lround(std::min(wanted[p] - lowest, 4 * radius)));
  }

  // A border face takes the patch that holds most of the faces around its vertices: borders straighten as if
  // they were under tension. Heavy patches weigh less, which keeps sizes together.
  void straighten() {
    const double mean = static_cast<double>(members_.size()) / patch_count_;
    std::vector<std::pair<uint32_t, int>> votes;
    for (int sweep = 0; sweep < 12; ++sweep) {
      size_t moved = 0;
      for (uint32_t f : members_) {
        const uint32_t own = patch_of_[f] - base_;
        votes.assign(1, {own, 0});
        for (uint32_t v : topology_.faces[f])
          for (uint32_t g : topology_.around_vertex(v)) {
            const uint32_t p = patch_of_[g] - base_;
            size_t i = 0;
            while (i < votes.size() && votes[i].first != p) ++i;
            if (i == votes.size()) votes.push_back({p, 0});
            ++votes[i].second;
          }
        if (votes.size() == 1 || sizes_[own] <= 1) continue;
        const auto score = [&](size_t i) {
          return votes[i].second - kPull * (sizes_[votes[i].first] / mean - 1.0);
        };
        size_t best = 0;
        for (size_t i = 1; i < votes.size(); ++i)
          if (score(i) > score(best) + (best == 0 ? 0.5 : 0.0)) best = i;
        if (best == 0) continue;
        bool touches = false;
        for (uint32_t g : topology_.across_edges(f)) touches |= patch_of_[g] - base_ == votes[best].first;
        if (!touches) continue;
        patch_of_[f] = votes[best].first + base_;
        --sizes_[own];
        ++sizes_[votes[best].first];
        ++moved;
      }
      if (moved == 0) break;
    }
  }

  // Border faces change sides where the border gets no longer and the balance better.
  void smooth() {
    const double mean = static_cast<double>(members_.size()) / patch_count_;
    for (int sweep = 0; sweep < 12; ++sweep) {
      size_t moved = 0;
      for (uint32_t f : members_) {
        const uint32_t own = patch_of_[f] - base_;
        uint32_t inside = 0, best = kNone, best_edges = 0;
        std::array<uint32_t, 3> others{};
        size_t count = 0;
        for (uint32_t g : topology_.across_edges(f)) {
          const uint32_t p = patch_of_[g] - base_;
          if (p == own)
            ++inside;
          else if (count < 3)
            others[count++] = p;
        }
        for (size_t i = 0; i < count; ++i) {
          const auto edges = static_cast<uint32_t>(
              std::count(others.begin(), others.begin() + static_cast<ptrdiff_t>(count), others[i]));
          if (edges > best_edges || (edges == best_edges && sizes_[others[i]] < sizes_[best])) {
            best = others[i];
            best_edges = edges;
          }
        }
        if (best == kNone || sizes_[own] <= 1) continue;
        const int gain = static_cast<int>(best_edges) - static_cast<int>(inside);
        const bool lighter = sizes_[best] + 1 < sizes_[own];
        const bool far_lighter = sizes_[own] > 1.02 * mean && sizes_[best] < sizes_[own] * 0.97;
        if (gain > 0    ? (sizes_[best] < 1.04 * mean || lighter || best < own)
            : gain == 0 ? lighter
                        : (gain == -1 && far_lighter && sweep < 8)) {
          patch_of_[f] = best + base_;
          --sizes_[own];
          ++sizes_[best];
          ++moved;
        }
      }
      if (moved == 0) break;
    }
  }

  const Topology& topology_;
  std::vector<uint32_t> members_;
  uint32_t patch_count_;
  std::vector<uint32_t>& patch_of_;
  uint32_t base_ = 0;
  std::vector<uint32_t>* distance_ = nullptr;
  std::vector<uint32_t>* stamp_ = nullptr;
  std::vector<uint32_t> centres_, weights_, sizes_;
};

// Patches in the order of a walk over their neighbours, so that neighbours get near numbers.
void renumber(const Topology& topology, Partition& partition) {
  const uint32_t upper = *std::max_element(partition.patch_of_face.begin(), partition.patch_of_face.end()) + 1;
  std::vector<std::vector<uint32_t>> neighbours(upper);
  for (uint32_t f = 0; f < topology.faces.size(); ++f)
    for (uint32_t g : topology.across_edges(f)) {
      const uint32_t a = partition.patch_of_face[f], b = partition.patch_of_face[g];
      if (a != b && (neighbours[a].empty() || neighbours[a].back() != b)) neighbours[a].push_back(b);
    }
  std::vector<uint32_t> number(upper, kNone), queue;
  uint32_t next = 0;
  for (uint32_t f = 0; f < topology.faces.size(); ++f) {
    if (number[partition.patch_of_face[f]] != kNone) continue;
    queue = {partition.patch_of_face[f]};
    number[queue[0]] = next++;
    for (size_t i = 0; i < queue.size(); ++i)
      for (uint32_t p : neighbours[queue[i]])
        if (number[p] == kNone) {
          number[p] = next++;
          queue.push_back(p);
        }
  }
  for (uint32_t& p : partition.patch_of_face) p = number[p];
  partition.patch_count = next;
}

}  // namespace

Partition partition_faces(FaceSpan faces, uint32_t vertex_count, const PartitionOptions& options,
                          const ThreadPool&) {
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
  const Topology topology(faces, vertex_count);
  const double target = static_cast<double>(faces.size()) / wanted;

  std::vector<uint8_t> seen(faces.size(), 0), vertex_seen(vertex_count, 0);
  std::vector<std::vector<uint32_t>> components;
  for (uint32_t start = 0; start < faces.size(); ++start) {
    if (seen[start]) continue;
    std::vector<uint32_t>& members = components.emplace_back(1, start);
    seen[start] = 1;
    for (size_t i = 0; i < members.size(); ++i)
      for (uint32_t v : faces[members[i]]) {
        if (std::exchange(vertex_seen[v], uint8_t{1})) continue;
        for (uint32_t g : topology.around_vertex(v))
          if (!std::exchange(seen[g], uint8_t{1})) members.push_back(g);
      }
  }
  // Small components share patches; large ones get theirs by size.
  uint32_t next = 0;
  double filled = 0;
  bool open = false;
  std::vector<uint32_t> distance(faces.size()), stamp(vertex_count, 0);
  for (std::vector<uint32_t>& members : components) {
    const auto size = static_cast<double>(members.size());
    if (size < target / 2) {
      if (open && filled + size > target) {
        ++next;
        filled = 0;
      }
      open = true;
      for (uint32_t f : members) partition.patch_of_face[f] = next;
      filled += size;
    }
  }
  if (open) ++next;
  for (std::vector<uint32_t>& members : components) {
    if (static_cast<double>(members.size()) < target / 2) continue;
    const auto share =
        static_cast<uint32_t>(std::max(1L, std::lround(static_cast<double>(members.size()) / target)));
    Component component(topology, std::move(members), share, partition.patch_of_face);
    component.cut(next, options.refine, distance, stamp);
    next += share;
  }
  renumber(topology, partition);
  return partition;
}

std::vector<uint32_t> distribute_patches(std::span<const uint64_t> face_counts, uint64_t patch_count) {
  const uint64_t total = std::accumulate(face_counts.begin(), face_counts.end(), uint64_t{0});
  std::vector<uint32_t> shares;
  for (uint64_t faces : face_counts) {
    const auto exact = total == 0 ? 0.0L : static_cast<long double>(faces) * patch_count / total;
    shares.push_back(static_cast<uint32_t>(std::clamp(exact, 1.0L, 4294967295.0L)));
  }
  return shares;
}

}  // namespace psplit
