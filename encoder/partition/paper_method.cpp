#include "encoder/partition/paper_method.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace psplit {
namespace {

// Rounds of k-means over cells, then rounds over faces that change only the starts. Refinement does the rest.
constexpr int kCellRounds = 16;
constexpr int kFaceRounds = 3;
// The share of its error that a start is corrected by in a round. The neighbours of a patch change too; with a
// much larger share patches take each other's places, and some vanish.
constexpr double kHaste = 0.3;

// The number of shelves is limited by this or by the number of faces, whichever is more. In longer shapes
// several distances share a shelf.
constexpr uint32_t kShelves = 1 << 20;

// Cells that are tried as a centre in a round. This bounds the time at a cell with very many neighbours.
constexpr int kTries = 50;

// A patch grows from a centre.
struct Patch {
  uint32_t number = 0;
  uint32_t centre = 0;  // a cell
  double share = 0;     // of the faces
  int64_t start = 0;    // the distance at the centre

  void correct_start(uint64_t face_count) {
    const double excess = std::min(static_cast<double>(face_count) / share, 2.0) - 1.0;
    // The radius of a disc with the area of `share` triangles. A start within it is not so late that a
    // neighbour's front passes the centre first. Without this limit a patch that is enclosed by others would
    // start earlier and earlier, and swallow everything around it once it gets out.
    const double radius = std::sqrt(share * 0.137832) * kEdgeLength;
    start = std::lround(std::clamp(static_cast<double>(start) + kHaste * excess * radius, -radius, radius));
  }
};

// k-means by paths over a graph of cells.
class Grouping {
 public:
  // `lengths` has one entry per link.
  Grouping(const CellGraph& cells, std::span<const uint32_t> lengths)
      : cells_(cells),
        lengths_(lengths),
        patch_of_(cells.cell_count(), kNoCell),
        distance_(cells.cell_count()) {}

  void run(std::span<Patch> patches) {
    std::vector<std::vector<uint32_t>> members(patches.size());
    for (int round = 0; round < kCellRounds; ++round) {
      grow(patches);
      for (std::vector<uint32_t>& some : members) some.clear();
      for (uint32_t c = 0; c < patch_of_.size(); ++c)
        if (patch_of_[c] != kNoCell) members[patch_of_[c]].push_back(c);
      for (size_t i = 0; i < patches.size(); ++i) {
        patches[i].correct_start(cells_.faces_of(members[i]));
        patches[i].centre = middle(members[i], patches[i].centre);
      }
    }
  }

 private:
  using Entry = std::pair<int64_t, uint32_t>;  // distance, cell
  static constexpr int64_t kFar = std::numeric_limits<int64_t>::max();

  // Assigns every cell to the nearest centre. A centre stays in its patch, however late that starts.
  void grow(std::span<const Patch> patches) {
    std::fill(distance_.begin(), distance_.end(), kFar);
    for (uint32_t i = 0; i < patches.size(); ++i) {
      distance_[patches[i].centre] = -kFar;
      patch_of_[patches[i].centre] = i;
    }
    for (const Patch& patch : patches) expand(patch.centre, patch.start, false);
    spread(false);
  }

  // The cell with the least variance, found by descent from neighbour to neighbour.
  uint32_t middle(std::span<const uint32_t> members, uint32_t centre) {
    const auto variance = [&](uint32_t cell) {
      for (const uint32_t c : members) distance_[c] = kFar;
      distance_[cell] = 0;
      front_.push({0, cell});
      return spread(true);
    };
    double least = variance(centre);
    int tries = 0;
    for (uint32_t from = kNoCell; std::exchange(from, centre) != centre;)
      for (const CellGraph::Link& link : cells_.around(from)) {
        if (patch_of_[link.cell] != patch_of_[from] || ++tries > kTries) continue;
        const double there = variance(link.cell);
        if (there >= least) continue;
        least = there;
        centre = link.cell;
      }
    return centre;
  }

  void expand(uint32_t cell, int64_t here, bool within_patch) {
    for (uint64_t i = cells_.first[cell]; i < cells_.first[cell + 1]; ++i) {
      const uint32_t other = cells_.links[i].cell;
      if (here + lengths_[i] >= distance_[other]) continue;
      if (within_patch && patch_of_[other] != patch_of_[cell]) continue;
      distance_[other] = here + lengths_[i];
      patch_of_[other] = patch_of_[cell];
      front_.push({distance_[other], other});
    }
  }

  // Returns the sum of squared distances over the faces.
  double spread(bool within_patch) {
    double sum = 0;
    while (!front_.empty()) {
      const auto [here, cell] = front_.top();
      front_.pop();
      if (here > distance_[cell]) continue;
      sum += static_cast<double>(here) * static_cast<double>(here) * cells_.face_counts[cell];
      expand(cell, here, within_patch);
    }
    return sum;
  }

  const CellGraph& cells_;
  std::span<const uint32_t> lengths_;
  std::vector<uint32_t> patch_of_;
  std::vector<int64_t> distance_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front_;
};

// One length per link: the shortest distance between the samples of two neighbouring cells.
std::vector<uint32_t> link_lengths(const DistanceMap& map, const FaceGraph& faces,
                                   std::span<const uint32_t> cell_of, const CellGraph& cells) {
  const Groups members(cell_of, cells.cell_count());
  std::vector<uint32_t> lengths(cells.links.size(), kUnreached);
  std::vector<uint64_t> link_to(cells.cell_count());
  for (uint32_t cell = 0; cell < cells.cell_count(); ++cell) {
    for (uint64_t i = cells.first[cell]; i < cells.first[cell + 1]; ++i) link_to[cells.links[i].cell] = i;
    for (const uint32_t face : members.of(cell))
      faces.for_each_link(face, [&](uint32_t across, uint32_t) {
        const uint32_t other = cell_of[across];
        if (other == cell) return;
        const uint64_t length = uint64_t{map.distance(face)} + kSpokeLength + map.distance(across);
        uint32_t& least = lengths[link_to[other]];
        least = static_cast<uint32_t>(std::min<uint64_t>(least, length));
      });
  }
  return lengths;
}

// The number of the nearest source for every face, or of a neighbour's source if the face is cut off from the
// nearest. kNoCell in components without a source.
std::vector<uint32_t> flood(const DistanceMap& map, const FaceGraph& faces, std::span<const Source> sources) {
  std::vector<uint32_t> number(faces.cell_count(), kNoCell), queue;
  queue.reserve(faces.cell_count());
  for (const Source& source : sources) {
    number[source.face] = source.number;
    queue.push_back(source.face);
  }
  for (const bool only_nearest : {true, false})
    for (size_t i = 0; i < queue.size(); ++i)
      faces.for_each_link(queue[i], [&, mine = number[queue[i]]](uint32_t next, uint32_t) {
        if (number[next] != kNoCell || (only_nearest && map.nearest(next) != mine)) return;
        number[next] = mine;
        queue.push_back(next);
      });
  return number;
}

// Assigns every face to the nearest centre, after rounds that change the starts to make patches equally large.
std::vector<uint32_t> grow_faces(DistanceMap& map, const FaceGraph& faces, std::span<const uint32_t> centres,
                                 std::span<Patch> patches, const std::vector<Source>& others) {
  for (int round = 0;; ++round) {
    int64_t earliest = 0;
    uint32_t numbers = 0;
    for (const Patch& patch : patches) earliest = std::min(earliest, patch.start);
    std::vector<Source> sources = others;
    for (const Patch& patch : patches)
      sources.push_back({centres[patch.centre], patch.number, static_cast<uint32_t>(patch.start - earliest)});
    std::stable_sort(sources.begin(), sources.end(),
                     [](const Source& a, const Source& b) { return a.start < b.start; });
    map.clear();
    map.add(sources);
    if (round == kFaceRounds || patches.empty()) return flood(map, faces, sources);
    for (const Source& source : sources) numbers = std::max(numbers, source.number + 1);
    std::vector<uint64_t> face_counts(numbers);
    for (uint32_t face = 0; face < faces.cell_count(); ++face) ++face_counts[map.nearest(face)];
    for (Patch& patch : patches) patch.correct_start(face_counts[patch.number]);
  }
}

}  // namespace

std::vector<uint32_t> sample_faces(DistanceMap& map, uint32_t face_count, uint32_t count) {
  std::vector<uint32_t> samples;
  const auto add = [&](uint32_t face) {
    const Source source{face, static_cast<uint32_t>(samples.size()), 0};
    map.add({&source, 1});
    samples.push_back(face);
  };
  for (uint32_t face = 0; face < face_count; ++face)
    if (map.distance(face) == kUnreached) add(face);
  uint32_t farthest = 0;
  for (uint32_t face = 0; face < face_count; ++face) farthest = std::max(farthest, map.distance(face));

  // Distances only decrease. A face waits on the shelf of a former distance, and moves to the right one when
  // its shelf is reached.
  int shift = 0;
  while (farthest >> shift > std::max(face_count, kShelves)) ++shift;
  std::vector<uint32_t> first((farthest >> shift) + 1, kNoCell), next(face_count);
  const auto shelve = [&](uint32_t face) {
    next[face] = std::exchange(first[map.distance(face) >> shift], face);
  };
  for (uint32_t face = face_count; face-- > 0;) shelve(face);
  for (size_t shelf = first.size(); shelf-- > 0;)
    while (first[shelf] != kNoCell && samples.size() < count) {
      const uint32_t face = std::exchange(first[shelf], next[first[shelf]]);
      const uint32_t distance = map.distance(face);
      if (distance >> shift < shelf)
        shelve(face);
      else if (distance > 0)
        add(face);
    }
  return samples;
}

Clusters cluster_faces(const DistanceMap& map, const FaceGraph& faces, std::vector<uint32_t> samples) {
  std::vector<Source> sources;
  for (uint32_t i = 0; i < samples.size(); ++i) sources.push_back({samples[i], i, 0});
  Clusters clusters{flood(map, faces, sources), std::move(samples)};
  std::vector<uint32_t> queue;
  for (uint32_t face = 0; face < faces.cell_count(); ++face) {
    if (clusters.cell_of[face] != kNoCell) continue;
    const auto cell = clusters.cell_of[face] = static_cast<uint32_t>(clusters.centres.size());
    clusters.centres.push_back(face);
    queue.assign(1, face);
    for (size_t i = 0; i < queue.size(); ++i)
      faces.for_each_link(queue[i], [&](uint32_t next, uint32_t) {
        if (std::exchange(clusters.cell_of[next], cell) != cell) queue.push_back(next);
      });
  }
  return clusters;
}

std::vector<uint32_t> group_clusters(DistanceMap& map, const FaceGraph& faces, const Clusters& clusters,
                                     const CellGraph& cells, std::span<const PatchSet> sets) {
  std::vector<Patch> patches;
  std::vector<Source> others;
  for (const PatchSet& set : sets) {
    if (set.patch_count == 1 || set.cells.size() <= set.patch_count) {
      for (uint32_t i = 0; i < set.cells.size(); ++i)
        others.push_back({clusters.centres[set.cells[i]], set.first_patch + (set.patch_count == 1 ? 0 : i), 0});
      continue;
    }
    const double share = static_cast<double>(cells.faces_of(set.cells)) / set.patch_count;
    std::vector<uint32_t> centres = set.cells;
    std::sort(centres.begin(), centres.end());
    for (uint32_t i = 0; i < set.patch_count; ++i) patches.push_back({set.first_patch + i, centres[i], share});
  }
  Grouping(cells, link_lengths(map, faces, clusters.cell_of, cells)).run(patches);
  return grow_faces(map, faces, clusters.centres, patches, others);
}

}  // namespace psplit
