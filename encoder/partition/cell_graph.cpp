#include "encoder/partition/cell_graph.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>
#include <utility>

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
  pool.for_ranges(coarsening.count, kGrain, [&](size_t begin, size_t end) {
    std::vector<CellGraph::Link>& out = links[begin / kGrain];
    for (size_t c = begin; c < end; ++c) {
      const size_t first = out.size();
      for (uint32_t i = cells.first[c]; i < cells.first[c + 1]; ++i) {
        coarse.face_counts[c] += graph.face_count(cells.members[i]);
        graph.for_each_link(cells.members[i], [&](uint32_t next, uint32_t edges) {
          if (coarsening.coarse_of[next] != c) out.push_back({coarsening.coarse_of[next], edges});
        });
      }
      const auto mine = out.begin() + static_cast<ptrdiff_t>(first);
      sort_few(out.data() + first, out.data() + out.size());
      auto last = mine;
      for (auto link = mine; link != out.end(); ++link) {
        if (last != mine && last[-1].cell == link->cell)
          last[-1].edges += link->edges;
        else
          *last++ = *link;
      }
      out.erase(last, out.end());
      coarse.first[c + 1] = static_cast<uint32_t>(out.size() - first);
    }
  });
  std::partial_sum(coarse.first.begin(), coarse.first.end(), coarse.first.begin());
  coarse.links.reserve(coarse.first.back());
  for (const auto& some : links) coarse.links.insert(coarse.links.end(), some.begin(), some.end());
  return coarse;
}

// Each edge is in the list of its lower vertex. When a face comes to an edge that is there, it is linked with
// the face that came there last.
class EdgeLinker {
 public:
  EdgeLinker(std::vector<std::array<uint32_t, 3>>& neighbours, std::vector<uint32_t>& newest_edge,
             size_t edge_count)
      : neighbours_(neighbours), newest_(newest_edge) {
    edges_.reserve(edge_count);
  }

  // The side `c` of a face is the edge from `lower` to `upper`.
  void add(uint32_t lower, uint32_t upper, uint32_t face, uint32_t c) {
    uint32_t& newest = newest_[lower];
    uint32_t at = newest, steps = 0;
    while (at != kNoCell && edges_[at].upper != upper) {
      at = edges_[at].next;
      if (++steps == kMostSteps) return add_far(lower, upper, face, c);
    }
    if (at != kNoCell) return link(std::exchange(edges_[at].last, {face, c}), {face, c});
    edges_.push_back({upper, newest, {face, c}});
    newest = static_cast<uint32_t>(edges_.size() - 1);
  }

  std::vector<FaceGraph::Extra> extra;  // links that do not fit

 private:
  struct Side {
    uint32_t face, c;
  };
  struct Edge {
    uint32_t upper, next;
    Side last;
  };
  // A list has at most this many edges. Further edges of its vertex are in a table.
  static constexpr uint32_t kMostSteps = 64;

  void link(Side from, Side to) {
    if (from.face == to.face) return;
    for (const auto& [side, other] : {std::pair(from, to.face), std::pair(to, from.face)}) {
      uint32_t& across = neighbours_[side.face][side.c];
      if (across == kNoCell)
        across = other;
      else
        extra.push_back({side.face, other});
    }
  }
  void add_far(uint32_t lower, uint32_t upper, uint32_t face, uint32_t c) {
    const auto [entry, is_new] = far_.try_emplace(uint64_t{lower} << 32 | upper, Side{face, c});
    if (!is_new) link(std::exchange(entry->second, {face, c}), {face, c});
  }

  std::vector<std::array<uint32_t, 3>>& neighbours_;
  std::vector<uint32_t>& newest_;  // of each vertex, in the list of edges
  std::vector<Edge> edges_;
  std::unordered_map<uint64_t, Side> far_;
};

}  // namespace

FaceGraph face_graph(std::span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count,
                     const ThreadPool& pool) {
  FaceGraph graph;
  graph.neighbours.assign(faces.size(), {kNoCell, kNoCell, kNoCell});
  std::vector<uint32_t> newest_edge(vertex_count, kNoCell);
  // Each task takes the edges of some vertices, so that no two write to a place.
  const size_t task_count =
      std::clamp<size_t>(faces.size() / kGrain, 1, static_cast<size_t>(pool.thread_count()));
  std::vector<std::vector<FaceGraph::Extra>> extra(task_count);
  pool.for_each(task_count, [&](size_t task) {
    const auto bound = [&](size_t t) { return static_cast<uint32_t>(uint64_t{vertex_count} * t / task_count); };
    const uint32_t begin = bound(task), end = bound(task + 1);
    EdgeLinker linker(graph.neighbours, newest_edge, faces.size() * 3 / 2 / task_count);
    for (uint32_t i = 0; i < faces.size(); ++i)
      for (uint32_t c = 0; c < 3; ++c) {
        const auto [lower, upper] = std::minmax(faces[i][c], faces[i][c == 2 ? 0 : c + 1]);
        if (lower >= begin && lower < end) linker.add(lower, upper, i, c);
      }
    extra[task] = std::move(linker.extra);
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
