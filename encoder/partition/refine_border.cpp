#include "encoder/partition/refine_border.h"

#include <algorithm>

namespace psplit {
namespace {

constexpr int kSweeps = 10;
// No move takes a patch further above its share than this, or feeds one that is there.
constexpr double kHeavy = 1.03;
// What a face may cost that leaves a patch above its share: the first of a row costs a vertex and an edge.
constexpr int kFare = 4;

class Refinement {
 public:
  Refinement(const Topology& topology, const Component& component, Clusters& clusters)
      : topology_(topology), component_(component), clusters_(clusters), queued_(topology.faces().size(), 0) {}

  void run() {
    const double mean =
        static_cast<double>(component_.faces.size()) / static_cast<double>(clusters_.sizes.size());
    swap_jagged_faces();
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      size_t moved = 0;
      for (const uint32_t f : border_faces()) moved += improve(f, mean, sweep) ? 1 : 0;
      if (moved == 0) break;
    }
  }

 private:
  uint32_t patch(uint32_t face) const { return clusters_.patch_of_face[face] - clusters_.base; }

  void move(uint32_t face, uint32_t to) {
    --clusters_.sizes[patch(face)];
    ++clusters_.sizes[to];
    clusters_.patch_of_face[face] = to + clusters_.base;
  }

  // Faces with a vertex that another patch has too.
  const std::vector<uint32_t>& border_faces() {
    for (const uint32_t f : border_) queued_[f] = 0;
    border_.clear();
    for (const uint32_t v : component_.vertices) {
      const auto around = topology_.around(v);
      const uint32_t first = patch(around.front());
      if (std::all_of(around.begin(), around.end(), [&](uint32_t f) { return patch(f) == first; })) continue;
      for (const uint32_t f : around)
        if (!queued_[f]) {
          queued_[f] = 1;
          border_.push_back(f);
        }
    }
    return border_;
  }

  // Patches across the edges of a face, the face's own left out, with the number of edges towards each.
  struct Neighbour {
    uint32_t patch = 0;
    int edges = 0;
  };
  int neighbours(uint32_t face, std::vector<Neighbour>& found) const {
    found.clear();
    int inside = 0;
    const auto& f = topology_.faces()[face];
    for (size_t c = 0; c < 3; ++c)
      topology_.across(face, f[c], f[(c + 1) % 3], [&](uint32_t other) {
        const uint32_t p = patch(other);
        if (p == patch(face)) {
          ++inside;
          return;
        }
        for (Neighbour& n : found)
          if (n.patch == p) {
            ++n.edges;
            return;
          }
        found.push_back({p, 1});
      });
    return inside;
  }

  void swap_jagged_faces() {
    for (const uint32_t f : border_faces()) {
      neighbours(f, found_);
      if (found_.size() == 1 && found_[0].edges >= 2 && found_[0].patch < patch(f) &&
          clusters_.sizes[patch(f)] > 1)
        move(f, found_[0].patch);
    }
  }

  // Vertices that the face's patch gives up, less those that are new to `to`.
  int shared_vertices_saved(uint32_t face, uint32_t to) const {
    int saved = 0;
    for (const uint32_t v : topology_.faces()[face]) {
      bool own_stays = false, other_has = false;
      for (const uint32_t g : topology_.around(v)) {
        own_stays |= g != face && patch(g) == patch(face);
        other_has |= patch(g) == to;
      }
      saved += (own_stays ? 0 : 1) - (other_has ? 0 : 1);
    }
    return saved;
  }

  bool improve(uint32_t face, double mean, int sweep) {
    const uint32_t own = patch(face);
    const int inside = neighbours(face, found_);
    if (found_.empty() || clusters_.sizes[own] <= 1) return false;
    const double own_size = clusters_.sizes[own];
    int best_score = -1000;
    uint32_t best = own;
    for (const Neighbour& n : found_) {
      const double other_size = clusters_.sizes[n.patch];
      int score = 2 * shared_vertices_saved(face, n.patch) + n.edges - inside;
      if (other_size + 1 > kHeavy * mean && other_size + 1 > own_size) score -= 100;
      // A patch above its share pays for its way down, while there are sweeps left to smooth after it.
      if (own_size > kHeavy * mean && other_size < 0.97 * own_size && sweep + 4 < kSweeps) score += kFare;
      if (score == 0 && other_size + 1 >= own_size) continue;
      if (score > best_score) {
        best_score = score;
        best = n.patch;
      }
    }
    if (best == own || best_score < 0) return false;
    move(face, best);
    return true;
  }

  const Topology& topology_;
  const Component& component_;
  Clusters& clusters_;
  std::vector<uint8_t> queued_;
  std::vector<uint32_t> border_;
  std::vector<Neighbour> found_;
};

}  // namespace

void refine_border(const Topology& topology, const Component& component, Clusters& clusters) {
  Refinement(topology, component, clusters).run();
}

}  // namespace psplit
