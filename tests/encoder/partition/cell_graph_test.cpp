#include "encoder/partition/cell_graph.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "encoder/partition/cells.h"

namespace psplit {
namespace {

using Faces = std::vector<std::array<uint32_t, 3>>;

// A row of `count` triangles, each with an edge in common with the next.
Faces strip(uint32_t count) {
  Faces faces;
  for (uint32_t i = 0; i < count; ++i) faces.push_back({i, i + 1, i + 2});
  return faces;
}

CellGraph graph_of(const Faces& faces, uint32_t vertex_count) {
  return face_graph(faces, vertex_count, ThreadPool(2));
}

std::vector<uint32_t> neighbours(const CellGraph& graph, uint32_t cell) {
  std::vector<uint32_t> found;
  for (const CellGraph::Link& link : graph.around(cell)) found.push_back(link.cell);
  std::sort(found.begin(), found.end());
  return found;
}

TEST(FaceGraph, LinksFacesAcrossEdgesAndNotAcrossVertices) {
  const CellGraph graph = graph_of({{0, 1, 2}, {2, 1, 3}, {3, 4, 5}}, 6);
  EXPECT_EQ(graph.cell_count(), 3u);
  EXPECT_EQ(neighbours(graph, 0), (std::vector<uint32_t>{1}));
  EXPECT_EQ(neighbours(graph, 1), (std::vector<uint32_t>{0}));
  EXPECT_TRUE(graph.around(2).empty());
}

TEST(FaceGraph, TakesAnEdgeOfManyFacesInTimeAndSpaceOfTheirNumber) {
  Faces book;
  for (uint32_t i = 0; i < 100000; ++i) book.push_back({0, 1, i + 2});
  const CellGraph graph = graph_of(book, 100002);
  EXPECT_EQ(graph.links.size(), 2u * 99999);
  EXPECT_EQ(neighbours(graph, 500), (std::vector<uint32_t>{499, 501}));
}

TEST(FaceGraph, HasNoLinkFromAFaceToItself) {
  const CellGraph graph = graph_of({{0, 0, 0}, {0, 0, 1}, {1, 2, 2}}, 3);
  for (uint32_t face = 0; face < 3; ++face)
    for (const uint32_t other : neighbours(graph, face)) EXPECT_NE(face, other);
}

TEST(Contract, AddsUpFacesAndCommonEdges) {
  const CellGraph graph = graph_of({{0, 1, 2}, {2, 1, 3}, {0, 2, 4}, {4, 2, 3}}, 5);
  const CellGraph coarse = contract(graph, std::vector<uint32_t>{0, 0, 1, 1}, 2);
  EXPECT_EQ(coarse.face_counts, (std::vector<uint32_t>{2, 2}));
  ASSERT_EQ(coarse.around(0).size(), 1u);
  EXPECT_EQ(coarse.around(0)[0].cell, 1u);
  EXPECT_EQ(coarse.around(0)[0].edges, 2u);
  EXPECT_EQ(coarse.around(1)[0].edges, 2u);
}

TEST(PairCells, JoinsNeighboursUpToTheLimit) {
  const CellGraph graph = graph_of(strip(8), 10);
  const Coarsening pairs = pair_cells(graph, 2);
  EXPECT_EQ(pairs.count, 4u);
  EXPECT_EQ(contract(graph, pairs.coarse_of, pairs.count).face_counts, (std::vector<uint32_t>{2, 2, 2, 2}));
  EXPECT_EQ(pair_cells(graph, 1).count, 8u);
}

}  // namespace
}  // namespace psplit
