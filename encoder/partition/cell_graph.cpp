#include "encoder/partition/cell_graph.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <deque>
#include <memory>
#include <numeric>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include "psplit/mesh.h"
#include "src/core/platform.h"
#include "src/object_pool.h"

namespace psplit {
namespace {

constexpr size_t kGrain = 1 << 14;

// counts[key + 1] is the number of items of a key. A prefix sum makes counts[key] the place of its first item.
std::vector<uint32_t> accumulate(std::vector<uint32_t>& counts) {
  std::partial_sum(counts.begin(), counts.end(), counts.begin());
  return {counts.begin(), counts.end() - 1};
}

// Sorts a few items faster than std::sort.
template <typename Item>
void sort_few(Item* first, Item* last) {
  constexpr ptrdiff_t kFew = 16;
  if (first == last) return;  // there may be no array
  if (last - first > kFew) return std::sort(first, last);
  for (Item* end = first + 1; end < last; ++end) {
    const Item item = *end;
    Item* at = end;
    for (; at > first && item < at[-1]; --at) *at = at[-1];
    *at = item;
  }
}

template <typename Graph>
CellGraph contract_cells(const Graph& graph, const Coarsening& coarsening, const ThreadPool& pool) {
  const Groups cells(coarsening.coarse_of, coarsening.count);
  CellGraph coarse;
  coarse.face_counts.resize(coarsening.count);
  coarse.first.resize(size_t{coarsening.count} + 1);
  std::vector<std::vector<CellGraph::Link>> links((size_t{coarsening.count} + kGrain - 1) / kGrain);
  // For each cell where the link to it would be, counted from the first of the cell whose links are made. What
  // is there tells whether it is, so that nothing is cleared between cells.
  ObjectPool<std::vector<uint32_t>> places_of_threads;
  const auto make_places = [&] { return std::make_unique<std::vector<uint32_t>>(coarsening.count); };
  pool.for_ranges(coarsening.count, kGrain, [&](size_t begin, size_t end) {
    std::vector<CellGraph::Link>& out = links[begin / kGrain];
    const ObjectPool<std::vector<uint32_t>>::Lease lease(places_of_threads, make_places);
    const std::span<uint32_t> places(*lease);
    const std::span<const uint32_t> coarse_of(coarsening.coarse_of);
    for (size_t c = begin; c < end; ++c) {
      const size_t first = out.size();
      uint32_t faces = 0;
      for (const uint32_t member : cells.of(c)) {
        faces += graph.face_count(member);
        graph.for_each_link(member, [&](uint32_t next, uint32_t edges) {
          const uint32_t cell = coarse_of[next];
          if (cell == c) return;
          const size_t place = first + places[cell];
          if (place < out.size() && out[place].cell == cell) {
            out[place].edges += edges;
          } else {
            places[cell] = static_cast<uint32_t>(out.size() - first);
            out.push_back({cell, edges});
          }
        });
      }
      sort_few(out.data() + first, out.data() + out.size());
      coarse.face_counts[c] = faces;
      coarse.first[c + 1] = static_cast<uint32_t>(out.size() - first);
    }
  });
  std::partial_sum(coarse.first.begin(), coarse.first.end(), coarse.first.begin());
  coarse.links.reserve(coarse.first.back());
  for (const auto& some : links) coarse.links.insert(coarse.links.end(), some.begin(), some.end());
  return coarse;
}

// An edge that a vertex owns: its other end, and the last side that came there.
struct OwnedEdge {
  uint32_t end, side;
};
constexpr OwnedEdge kNoEdge = {kNoCell, kNoCell};

// The first edges that a vertex owns. In a closed mesh these are three, on average. Unused ones come last.
struct alignas(32) FirstEdges {
  static constexpr uint32_t kEdges = 4;

  OwnedEdge edges[kEdges];
};
// So that an Array of them is first written by the task that uses it.
static_assert(std::is_trivially_default_constructible_v<FirstEdges>);

// Some further edges, in a cache line.
struct alignas(64) FurtherEdges {
  static constexpr uint32_t kEdges = 7;

  FurtherEdges() { std::ranges::fill(edges, kNoEdge); }

  OwnedEdge edges[kEdges];
  uint32_t next = kNoCell;  // the vertex's next ones
  uint32_t count = 0;
};

// The place of the edge to `end`, or `count`, the first free place, if it is not there. Of unused edges, none
// is found. Matches are collected as bits: compilers turn conditional choices into branches. Comparing several
// places at once would be slower: such a load waits for the last stores of single places.
template <uint32_t kEdges>
uint32_t place_of(uint32_t end, const OwnedEdge (&edges)[kEdges], uint32_t count) {
  uint32_t places = uint32_t{1} << count;
  for (uint32_t k = 0; k < kEdges; ++k) places |= uint32_t{edges[k].end == end} << k;
  return static_cast<uint32_t>(std::countr_zero(places));
}

// When a face comes to an edge that is there, it is linked with the face that came there last. Nearly nothing
// branches, because no processor predicts whether an edge is there.
class EdgeLinker {
 public:
  // For edges that the vertices [first, first + edges.size()) own.
  EdgeLinker(std::vector<std::array<uint32_t, 3>>& neighbours, uint32_t first, std::span<FirstEdges> edges)
      : sides_(neighbours[0].data()), first_(first), edges_(edges), counts_(edges.size(), 0) {
    for (FirstEdges& of : edges_) std::ranges::fill(of.edges, kNoEdge);
  }
  EdgeLinker(const EdgeLinker&) = delete;
  EdgeLinker& operator=(const EdgeLinker&) = delete;

  // Adds the edges of a face that these vertices own.
  void add_face(uint32_t face, const std::array<uint32_t, 3>& vertices) {
    const auto [a, b, c] = vertices;
    add_side(a, b, 3 * face, face);
    add_side(b, c, 3 * face + 1, face);
    add_side(c, a, 3 * face + 2, face);
  }

  std::vector<FaceGraph::Extra> extra;  // links that do not fit

 private:
  // Of a vertex. Its edges beyond these are in a table.
  static constexpr uint32_t kMostFurther = 8;

  // The edge belongs to one of its vertices, the same in either direction. About half of a vertex's edges are
  // its own, however vertices are numbered.
  PSPLIT_INLINE void add_side(uint32_t a, uint32_t b, uint32_t side, uint32_t face) {
    const bool is_odd = ((a ^ b) & 1) != 0;
    const uint32_t owner = core::select(core::mask((a < b) != is_odd), a, b);
    if (owner - first_ < edges_.size()) add_edge(owner - first_, a ^ b ^ owner, side, face);
  }
  // Side `side` of the mesh, which is of this face, is the edge from the vertex with this number here to `end`.
  PSPLIT_INLINE void add_edge(uint32_t owner, uint32_t end, uint32_t side, uint32_t face) {
    uint8_t& count = counts_[owner];
    OwnedEdge(&edges)[FirstEdges::kEdges] = edges_[owner].edges;
    const uint32_t place = place_of(end, edges, count);
    if (place == FirstEdges::kEdges) [[unlikely]]
      return add_further(owner, end, side, face);
    count = static_cast<uint8_t>(count + (place == count ? 1 : 0));
    edges[place].end = end;
    link(std::exchange(edges[place].side, side), side, face);
  }
  // `from` is kNoCell, or a side whose face is to be linked with this one across `side`.
  PSPLIT_INLINE void link(uint32_t from, uint32_t side, uint32_t face) {
    const uint32_t other = from / 3, is_linked = core::mask((from != kNoCell) & (other != face));
    sides_[side] = core::select(is_linked, other, kNoCell);
    uint32_t& across = places_[is_linked & 1][from & is_linked];
    if (across != kNoCell) [[unlikely]]
      extra.push_back({other, face});
    else
      across = core::select(is_linked, face, kNoCell);
  }
  void add_further(uint32_t owner, uint32_t end, uint32_t side, uint32_t face) {
    if (further_.empty()) further_.assign(edges_.size(), kNoCell);
    uint32_t at = further_[owner];
    if (at == kNoCell) at = further_[owner] = add_more();
    for (uint32_t i = 1;; ++i) {
      FurtherEdges& further = more_[at];
      const uint32_t place = place_of(end, further.edges, further.count);
      if (place < FurtherEdges::kEdges) {
        further.count += place == further.count ? 1 : 0;
        further.edges[place].end = end;
        return link(std::exchange(further.edges[place].side, side), side, face);
      }
      if (i == kMostFurther) break;
      if (further.next == kNoCell) further.next = add_more();
      at = further.next;
    }
    const auto edge = far_.try_emplace(uint64_t{owner} << 32 | end, kNoCell).first;
    link(std::exchange(edge->second, side), side, face);
  }
  uint32_t add_more() {
    more_.emplace_back();
    return static_cast<uint32_t>(more_.size()) - 1;
  }

  uint32_t* const sides_;       // the face across each side
  uint32_t nothing_ = kNoCell;  // is written, and stays kNoCell, when no side is linked
  uint32_t* const places_[2] = {&nothing_, sides_};
  const uint32_t first_;
  const std::span<FirstEdges> edges_;  // of each vertex
  std::vector<uint8_t> counts_;        // of each vertex's first edges
  std::vector<uint32_t> further_;      // for each vertex the place of its further edges in more_, or kNoCell
  std::deque<FurtherEdges> more_;
  std::unordered_map<uint64_t, uint32_t> far_;  // the last side of each edge
};

}  // namespace

FaceGraph face_graph(std::span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count,
                     const ThreadPool& pool) {
  FaceGraph graph;
  graph.neighbours.resize(faces.size());
  if (faces.empty()) return graph;
  // Each task takes the edges that some vertices own, so that no two write to a place. Many more vertices than
  // a closed mesh has, half as many as faces, follow in further rounds, so that memory is bounded by the faces.
  const size_t task_count =
      std::clamp<size_t>(faces.size() / kGrain, 1, static_cast<size_t>(pool.thread_count()));
  const uint64_t most_at_once = std::max<uint64_t>(faces.size() / 4 * 3, kGrain),
                 at_once = std::clamp<uint64_t>(vertex_count, 1, most_at_once),
                 share = (at_once + task_count - 1) / task_count;
  // Allocated here, because threads other than this one do not get large pages (expect_large_arrays).
  Array<FirstEdges> edges(static_cast<size_t>(share * task_count));
  std::vector<std::vector<FaceGraph::Extra>> extra(task_count);
  for (uint64_t first = 0; first < vertex_count; first += share * task_count)
    pool.for_each(task_count, [&](size_t task) {
      const auto begin = static_cast<uint32_t>(std::min<uint64_t>(first + share * task, vertex_count)),
                 end = static_cast<uint32_t>(std::min<uint64_t>(begin + share, vertex_count));
      EdgeLinker linker(graph.neighbours, begin,
                        std::span(edges).subspan(static_cast<size_t>(share) * task, end - begin));
      for (uint32_t i = 0; i < faces.size(); ++i) linker.add_face(i, faces[i]);
      extra[task].insert(extra[task].end(), linker.extra.begin(), linker.extra.end());
    });
  std::vector<FaceGraph::Extra> all;
  for (const auto& some : extra) all.insert(all.end(), some.begin(), some.end());
  graph.set_extra(std::move(all));
  return graph;
}

void FaceGraph::set_extra(std::vector<Extra> links) {
  extra = std::move(links);
  has_extra.clear();
  if (extra.empty()) return;
  std::sort(extra.begin(), extra.end());
  has_extra.assign(neighbours.size(), 0);
  for (const Extra& link : extra) has_extra[link.face] = 1;
}

CellGraph contract(const FaceGraph& graph, const Coarsening& coarsening, const ThreadPool& pool) {
  return contract_cells(graph, coarsening, pool);
}
CellGraph contract(const CellGraph& graph, const Coarsening& coarsening, const ThreadPool& pool) {
  return contract_cells(graph, coarsening, pool);
}

std::vector<uint32_t> radii(const CellGraph& graph) {
  std::vector<uint32_t> radius;
  radius.reserve(graph.cell_count());
  for (const uint32_t faces : graph.face_counts)
    radius.push_back(static_cast<uint32_t>(std::lround(8.0 * std::sqrt(static_cast<double>(faces)))));
  return radius;
}

Groups::Groups(std::span<const uint32_t> group_of, uint32_t group_count)
    : first(size_t{group_count} + 1), members(group_of.size()) {
  for (const uint32_t group : group_of) ++first[group + 1];
  std::vector<uint32_t> next = accumulate(first);
  for (uint32_t i = 0; i < group_of.size(); ++i) members[next[group_of[i]]++] = i;
}

}  // namespace psplit
