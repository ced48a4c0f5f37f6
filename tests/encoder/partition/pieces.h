// What the tests of partitions share.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "encoder/partition/cell_graph.h"
#include "encoder/partition/path_distance.h"

namespace psplit {

inline constexpr PathDistance kDistances[] = {PathDistance::kDijkstra, PathDistance::kGeodesic};

// Pieces of equal number, faces being joined by edges.
inline size_t piece_count(const FaceGraph& graph, const std::vector<uint32_t>& number) {
  std::vector<uint8_t> seen(number.size(), 0);
  size_t pieces = 0;
  for (uint32_t start = 0; start < number.size(); ++start) {
    if (std::exchange(seen[start], uint8_t{1}) != 0) continue;
    ++pieces;
    std::vector<uint32_t> piece{start};
    for (size_t i = 0; i < piece.size(); ++i)
      graph.for_each_link(piece[i], [&](uint32_t next, uint32_t) {
        if (number[next] == number[start] && std::exchange(seen[next], uint8_t{1}) == 0) piece.push_back(next);
      });
  }
  return pieces;
}

}  // namespace psplit
