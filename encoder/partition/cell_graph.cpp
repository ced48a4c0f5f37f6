#include "encoder/partition/cell_graph.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "src/shared_values.h"

namespace psplit {
namespace {

constexpr size_t kGrain = 1 << 14;

// counts[key + 1] is the number of items of a key. A prefix sum makes counts[key] the place of its first item.
std::vector<uint32_t> accumulate(std::vector<uint32_t>& counts) {
  std::partial_sum(counts.begin(), counts.end(), counts.begin());
  return {counts.begin(), counts.end() - 1};
}

// Returns the value before. A thread that is alone takes a fifth of the time.
uint32_t add_one(uint32_t& counter, bool is_alone) { return is_alone ? counter++ : add_one_shared(counter); }

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

}  // namespace

FaceGraph face_graph(std::span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count,
                     const ThreadPool& pool) {
  // Sides are sorted by the lower vertex of their edge, then by the upper, so the sides of one edge are
  // adjacent.
  struct Side {
    uint32_t upper, face;
    auto operator<=>(const Side&) const = default;
  };
  const bool is_alone = pool.thread_count() == 1;
  std::vector<uint32_t> first_side(size_t{vertex_count} + 1);
  pool.for_ranges(faces.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      for (size_t c = 0; c < 3; ++c)
        add_one(first_side[std::min(faces[i][c], faces[i][(c + 1) % 3]) + 1], is_alone);
  });
  std::vector<uint32_t> next = accumulate(first_side);
  std::vector<Side> sides(faces.size() * 3);
  pool.for_ranges(faces.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      for (size_t c = 0; c < 3; ++c) {
        const auto [lower, upper] = std::minmax(faces[i][c], faces[i][(c + 1) % 3]);
        sides[add_one(next[lower], is_alone)] = {upper, static_cast<uint32_t>(i)};
      }
  });
  FaceGraph graph;
  graph.neighbours.assign(faces.size(), {kNoCell, kNoCell, kNoCell});
  // Sets a link across a side that has none yet. Returns false if there is no such side.
  const auto link = [&](uint32_t face, uint32_t lower, uint32_t upper, uint32_t other) {
    // A face with two equal vertices has an edge twice.
    for (size_t c = 0; c < 3; ++c) {
      const auto [a, b] = std::minmax(faces[face][c], faces[face][(c + 1) % 3]);
      if (a != lower || b != upper || graph.neighbours[face][c] != kNoCell) continue;
      graph.neighbours[face][c] = other;
      return true;
    }
    return false;
  };
  std::vector<std::vector<FaceGraph::Extra>> extra((size_t{vertex_count} + kGrain - 1) / kGrain);
  pool.for_ranges(vertex_count, kGrain, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) {
      Side* const first = sides.data() + first_side[v];
      Side* const last = sides.data() + first_side[v + 1];
      sort_few(first, last);
      for (const Side* side = first; side + 1 < last; ++side) {
        const auto [upper, face] = side[0];
        const uint32_t other = side[1].face, lower = static_cast<uint32_t>(v);
        if (upper != side[1].upper || face == other) continue;
        if (!link(face, lower, upper, other)) extra[begin / kGrain].push_back({face, other});
        if (!link(other, lower, upper, face)) extra[begin / kGrain].push_back({other, face});
      }
    }
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

FaceGraph reorder(const FaceGraph& graph, std::span<const uint32_t> order, const ThreadPool& pool) {
  std::vector<uint32_t> place(order.size());
  pool.for_ranges(order.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) place[order[i]] = static_cast<uint32_t>(i);
  });
  FaceGraph reordered;
  reordered.neighbours.resize(order.size());
  pool.for_ranges(order.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      for (size_t c = 0; c < 3; ++c) {
        const uint32_t other = graph.neighbours[order[i]][c];
        reordered.neighbours[i][c] = other == kNoCell ? kNoCell : place[other];
      }
  });
  std::vector<FaceGraph::Extra> extra;
  for (const FaceGraph::Extra& link : graph.extra) extra.push_back({place[link.face], place[link.other]});
  reordered.set_extra(std::move(extra));
  return reordered;
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
