#include "encoder/partition/cell_graph.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace psplit {
namespace {

// Numbers of items by key, counted in counts[key + 1], become where the items of each key begin.
std::vector<uint32_t> accumulate(std::vector<uint32_t>& counts) {
  std::partial_sum(counts.begin(), counts.end(), counts.begin());
  return {counts.begin(), counts.end() - 1};
}

}  // namespace

CellGraph face_graph(std::span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count,
                     const ThreadPool& pool) {
  // Sides of faces by the lower vertex of their edge, then by the upper: sides of one edge meet.
  struct Side {
    uint32_t upper, face;
  };
  std::vector<uint32_t> first_side(size_t{vertex_count} + 1);
  for (const auto& f : faces)
    for (size_t c = 0; c < 3; ++c) ++first_side[std::min(f[c], f[(c + 1) % 3]) + 1];
  std::vector<uint32_t> next = accumulate(first_side);
  std::vector<Side> sides(faces.size() * 3);
  for (uint32_t i = 0; i < faces.size(); ++i)
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t a = faces[i][c], b = faces[i][(c + 1) % 3];
      sides[next[std::min(a, b)]++] = {std::max(a, b), i};
    }
  pool.for_ranges(vertex_count, 1 << 14, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v)
      std::sort(sides.begin() + first_side[v], sides.begin() + first_side[v + 1],
                [](const Side& a, const Side& b) {
                  return a.upper != b.upper ? a.upper < b.upper : a.face < b.face;
                });
  });
  const auto for_each_pair = [&](auto visit) {
    for (uint32_t v = 0; v < vertex_count; ++v)
      for (uint32_t i = first_side[v] + 1; i < first_side[v + 1]; ++i)
        if (sides[i - 1].upper == sides[i].upper && sides[i - 1].face != sides[i].face)
          visit(sides[i - 1].face, sides[i].face);
  };

  CellGraph graph;
  graph.face_counts.assign(faces.size(), 1);
  graph.first.resize(faces.size() + 1);
  for_each_pair([&](uint32_t a, uint32_t b) {
    ++graph.first[a + 1];
    ++graph.first[b + 1];
  });
  next = accumulate(graph.first);
  graph.links.resize(graph.first.back());
  for_each_pair([&](uint32_t a, uint32_t b) {
    graph.links[next[a]++] = {b, 1};
    graph.links[next[b]++] = {a, 1};
  });
  return graph;
}

CellGraph contract(const CellGraph& graph, std::span<const uint32_t> coarse_of, uint32_t coarse_count) {
  std::vector<uint32_t> first_member(size_t{coarse_count} + 1), members(coarse_of.size());
  for (const uint32_t c : coarse_of) ++first_member[c + 1];
  std::vector<uint32_t> next = accumulate(first_member);
  for (uint32_t i = 0; i < coarse_of.size(); ++i) members[next[coarse_of[i]]++] = i;

  CellGraph coarse;
  coarse.face_counts.resize(coarse_count);
  coarse.first.reserve(size_t{coarse_count} + 1);
  coarse.first.push_back(0);
  coarse.links.reserve(graph.links.size());
  std::vector<size_t> end_of_link(coarse_count);  // of the latest link to a cell
  for (uint32_t c = 0; c < coarse_count; ++c) {
    for (uint32_t i = first_member[c]; i < first_member[c + 1]; ++i) {
      coarse.face_counts[c] += graph.face_counts[members[i]];
      for (const CellGraph::Link& link : graph.around(members[i])) {
        const uint32_t other = coarse_of[link.cell];
        if (other == c) continue;
        if (end_of_link[other] <= coarse.first[c]) {
          coarse.links.push_back({other, 0});
          end_of_link[other] = coarse.links.size();
        }
        coarse.links[end_of_link[other] - 1].edges += link.edges;
      }
    }
    coarse.first.push_back(static_cast<uint32_t>(coarse.links.size()));
  }
  return coarse;
}

std::vector<uint32_t> radii(const CellGraph& graph) {
  std::vector<uint32_t> radius;
  radius.reserve(graph.cell_count());
  for (const uint32_t faces : graph.face_counts)
    radius.push_back(static_cast<uint32_t>(std::lround(8.0 * std::sqrt(static_cast<double>(faces)))));
  return radius;
}

}  // namespace psplit
