#include <algorithm>
#include <numeric>

#include "encoder/partition/partition_steps.h"

namespace psplit {
namespace {

constexpr uint32_t kStretch = 1 << 16;
// With more than this many times the wanted cells, the ends of the stretches have cut too many cells off.
constexpr double kCutOff = 1.5;

// Cells that some others are next to, with the edges between them.
class Neighbours {
 public:
  struct Entry {
    uint32_t cell, edges;
  };

  void clear() { entries_.clear(); }
  void count(uint32_t cell, uint32_t edges) {
    for (Entry& entry : entries_)
      if (entry.cell == cell) {
        entry.edges += edges;
        return;
      }
    entries_.push_back({cell, edges});
  }
  // Removes and returns the cell with the most edges among the cells that `may_be` allows: of equal cells, the
  // first in the list. Returns kNoCell if it allows none.
  template <typename MayBe>
  uint32_t take_best(MayBe may_be) {
    size_t best = entries_.size();
    for (size_t i = 0; i < entries_.size(); ++i)
      if ((best == entries_.size() || entries_[i].edges > entries_[best].edges) && may_be(entries_[i].cell))
        best = i;
    if (best == entries_.size()) return kNoCell;
    const uint32_t cell = entries_[best].cell;
    entries_[best] = entries_.back();
    entries_.pop_back();
    return cell;
  }

 private:
  std::vector<Entry> entries_;
};

// A stretch of a graph: its cells [begin, end).
template <typename Graph>
struct Stretch {
  const Graph& graph;
  uint32_t begin, end;
  uint32_t members, face_limit;   // as in grow_cells
  std::vector<uint32_t>& number;  // of the grown cell, from 0 on; kNoCell if it has none yet

  bool has(uint32_t cell) const { return cell >= begin && cell < end; }
  bool is_left(uint32_t cell) const { return has(cell) && number[cell] == kNoCell; }
};

// Grows cells of faces breadth-first, so that they are about as long as wide. Much smaller remnants between
// cells join one of these. Returns the number of grown cells.
uint32_t grow(const Stretch<FaceGraph>& stretch) {
  const uint32_t members = std::min(stretch.members, stretch.face_limit);
  std::vector<uint32_t>& number = stretch.number;
  std::vector<uint32_t> sizes;           // of the grown cells
  std::vector<uint32_t> faces(members);  // of the growing cell, `size` of them
  uint32_t size = 0;
  Neighbours around;
  for (uint32_t seed = stretch.begin; seed < stretch.end; ++seed) {
    if (number[seed] != kNoCell) continue;
    const auto own = static_cast<uint32_t>(sizes.size());
    const auto take = [&](uint32_t face, uint32_t) {
      if (size == members || !stretch.is_left(face)) return;
      number[face] = own;
      faces[size++] = face;
    };
    size = 0;
    take(seed, 1);
    for (uint32_t i = 0; i < size && size < members; ++i) stretch.graph.for_each_link(faces[i], take);
    if (size < members && (size == 1 || 3 * size < members)) {
      around.clear();
      for (uint32_t i = 0; i < size; ++i)
        stretch.graph.for_each_link(faces[i], [&](uint32_t next, uint32_t edges) {
          if (stretch.has(next) && number[next] != own) around.count(number[next], edges);
        });
      const uint32_t most = std::min(size == 1 ? 2 * members : members + members / 2, stretch.face_limit);
      const uint32_t joined = around.take_best([&](uint32_t cell) { return sizes[cell] + size <= most; });
      if (joined != kNoCell) {
        for (uint32_t i = 0; i < size; ++i) number[faces[i]] = joined;
        sizes[joined] += size;
        continue;
      }
    }
    sizes.push_back(size);
  }
  return static_cast<uint32_t>(sizes.size());
}

// Grows cells of cells: each repeatedly takes the neighbour with which it shares most edges.
class CellGrower {
 public:
  explicit CellGrower(const Stretch<CellGraph>& stretch) : s_(stretch) {}

  // Returns the number of grown cells.
  uint32_t run() {
    for (uint32_t seed = s_.begin; seed < s_.end; ++seed)
      if (s_.number[seed] == kNoCell) grow_from(seed);
    return static_cast<uint32_t>(face_counts_.size());
  }

 private:
  void grow_from(uint32_t seed) {
    const auto own = static_cast<uint32_t>(face_counts_.size());
    uint32_t faces = 0, count = 0;
    around_.clear();
    for (uint32_t newest = seed; newest != kNoCell;) {
      s_.number[newest] = own;
      faces += s_.graph.face_count(newest);
      if (++count == s_.members) break;
      s_.graph.for_each_link(newest, [&](uint32_t next, uint32_t edges) {
        if (s_.is_left(next)) around_.count(next, edges);
      });
      newest =
          around_.take_best([&](uint32_t cell) { return faces + s_.graph.face_count(cell) <= s_.face_limit; });
    }
    if (count == 1 && s_.members > 1 && joins_neighbour(seed, own, faces)) return;
    face_counts_.push_back(faces);
    member_counts_.push_back(count);
  }

  // A single cell that is left between others joins one of them, if any has room.
  bool joins_neighbour(uint32_t seed, uint32_t own, uint32_t faces) {
    around_.clear();
    s_.graph.for_each_link(seed, [&](uint32_t next, uint32_t edges) {
      if (s_.has(next) && s_.number[next] != kNoCell && s_.number[next] != own)
        around_.count(s_.number[next], edges);
    });
    const uint32_t best = around_.take_best([&](uint32_t cell) {
      return member_counts_[cell] < 2 * s_.members && face_counts_[cell] + faces <= s_.face_limit;
    });
    if (best == kNoCell) return false;
    s_.number[seed] = best;
    face_counts_[best] += faces;
    ++member_counts_[best];
    return true;
  }

  const Stretch<CellGraph>& s_;
  std::vector<uint32_t> face_counts_, member_counts_;  // of the grown cells
  Neighbours around_;                                  // of the cell that grows
};
uint32_t grow(const Stretch<CellGraph>& stretch) { return CellGrower(stretch).run(); }

template <typename Graph>
Coarsening grow_all(const Graph& graph, uint32_t members, uint32_t face_limit, const ThreadPool& pool) {
  const uint32_t cell_count = graph.cell_count();
  Coarsening grown{std::vector<uint32_t>(cell_count, kNoCell), 0};
  std::vector<uint32_t> first(cell_count / kStretch + 2, 0);  // the first number of each stretch
  pool.for_ranges(cell_count, kStretch, [&](size_t begin, size_t end) {
    first[begin / kStretch + 1] = grow(Stretch<Graph>{
        graph, static_cast<uint32_t>(begin), static_cast<uint32_t>(end), members, face_limit, grown.coarse_of});
  });
  std::partial_sum(first.begin(), first.end(), first.begin());
  grown.count = first.back();
  if (cell_count > kStretch && static_cast<double>(grown.count) * members > kCutOff * cell_count) {
    grown.coarse_of.assign(cell_count, kNoCell);
    grown.count = grow(Stretch<Graph>{graph, 0, cell_count, members, face_limit, grown.coarse_of});
    return grown;
  }
  pool.for_ranges(cell_count, kStretch, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) grown.coarse_of[i] += first[begin / kStretch];
  });
  return grown;
}

}  // namespace

Coarsening grow_cells(const FaceGraph& graph, uint32_t members, uint32_t face_limit, const ThreadPool& pool) {
  return grow_all(graph, members, face_limit, pool);
}
Coarsening grow_cells(const CellGraph& graph, uint32_t members, uint32_t face_limit, const ThreadPool& pool) {
  return grow_all(graph, members, face_limit, pool);
}

}  // namespace psplit
