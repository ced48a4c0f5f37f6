#include "encoder/partition/cell_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <utility>

#include "encoder/partition/partition_steps.h"

namespace psplit {
namespace {

using Faces = std::vector<std::array<uint32_t, 3>>;

// A row of `count` triangles, each with an edge in common with the next.
Faces strip(uint32_t count) {
  Faces faces;
  for (uint32_t i = 0; i < count; ++i) faces.push_back({i, i + 1, i + 2});
  return faces;
}

FaceGraph graph_of(const Faces& faces, uint32_t vertex_count) {
  return face_graph(faces, vertex_count, ThreadPool(2));
}

std::vector<uint32_t> neighbours(const FaceGraph& graph, uint32_t cell) {
  std::vector<uint32_t> found;
  graph.for_each_link(cell, [&](uint32_t next, uint32_t) { found.push_back(next); });
  std::sort(found.begin(), found.end());
  return found;
}

TEST(FaceGraph, LinksFacesAcrossEdgesAndNotAcrossVertices) {
  const FaceGraph graph = graph_of({{0, 1, 2}, {2, 1, 3}, {3, 4, 5}}, 6);
  EXPECT_EQ(graph.cell_count(), 3u);
  EXPECT_EQ(neighbours(graph, 0), (std::vector<uint32_t>{1}));
  EXPECT_EQ(neighbours(graph, 1), (std::vector<uint32_t>{0}));
  EXPECT_TRUE(neighbours(graph, 2).empty());
}

TEST(FaceGraph, TakesAnEdgeOfManyFacesInTimeAndSpaceOfTheirNumber) {
  Faces book;
  for (uint32_t i = 0; i < 100000; ++i) book.push_back({0, 1, i + 2});
  const FaceGraph graph = graph_of(book, 100002);
  EXPECT_EQ(neighbours(graph, 0), (std::vector<uint32_t>{1}));
  for (uint32_t page = 1; page + 1 < 100000; ++page)
    ASSERT_EQ(neighbours(graph, page), (std::vector<uint32_t>{page - 1, page + 1}));
  EXPECT_EQ(neighbours(graph, 99999), (std::vector<uint32_t>{99998}));
}

TEST(FaceGraph, LinksAllFacesAroundAHub) {
  constexpr uint32_t kFaces = 1000;
  Faces fan;
  for (uint32_t i = 0; i < kFaces; ++i) fan.push_back({0, i + 1, (i + 1) % kFaces + 1});
  for (const int threads : {1, 2}) {
    const FaceGraph graph = face_graph(fan, kFaces + 1, ThreadPool(threads));
    for (uint32_t i = 0; i < kFaces; ++i) {
      std::vector<uint32_t> expected{(i + kFaces - 1) % kFaces, (i + 1) % kFaces};
      std::sort(expected.begin(), expected.end());
      ASSERT_EQ(neighbours(graph, i), expected) << i;
    }
  }
}

// Vertices own from none to hundreds of edges, and edges have from one face to many; some faces repeat a
// vertex. The last mesh has several tasks on two threads, and several rounds of vertices.
TEST(FaceGraph, LinksEachFaceWithTheLastOneAtItsEdge) {
  std::mt19937 random(7);
  for (const auto& [vertex_count, face_count] :
       {std::pair{4u, 3000u}, {20u, 3000u}, {60u, 3000u}, {400u, 3000u}, {100'000u, 40'000u}}) {
    Faces faces(face_count);
    for (auto& face : faces)
      for (uint32_t& vertex : face) {
        const uint32_t limit = random() % 3 == 0 ? 3 : vertex_count;  // three are hubs
        vertex = static_cast<uint32_t>(random() % limit);
      }
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> last;  // the last face at an edge
    std::vector<std::vector<uint32_t>> expected(faces.size());
    for (uint32_t face = 0; face < faces.size(); ++face)
      for (uint32_t c = 0; c < 3; ++c) {
        const auto [edge, is_new] =
            last.try_emplace(std::minmax(faces[face][c], faces[face][(c + 1) % 3]), face);
        const uint32_t before = std::exchange(edge->second, face);
        if (is_new || before == face) continue;
        expected[face].push_back(before);
        expected[before].push_back(face);
      }
    for (std::vector<uint32_t>& others : expected) std::ranges::sort(others);
    for (const int threads : {1, 2}) {
      const FaceGraph graph = face_graph(faces, vertex_count, ThreadPool(threads));
      for (uint32_t face = 0; face < faces.size(); ++face)
        ASSERT_EQ(neighbours(graph, face), expected[face]) << face << " of " << vertex_count << " vertices";
    }
  }
}

TEST(FaceGraph, HasNoLinkFromAFaceToItself) {
  const FaceGraph graph = graph_of({{0, 0, 0}, {0, 0, 1}, {1, 2, 2}}, 3);
  for (uint32_t face = 0; face < 3; ++face)
    for (const uint32_t other : neighbours(graph, face)) EXPECT_NE(face, other);
}

TEST(Contract, AddsUpFacesAndCommonEdges) {
  const FaceGraph graph = graph_of({{0, 1, 2}, {2, 1, 3}, {0, 2, 4}, {4, 2, 3}}, 5);
  const CellGraph coarse = contract(graph, {{0, 0, 1, 1}, 2}, ThreadPool(2));
  EXPECT_EQ(coarse.face_counts, (std::vector<uint32_t>{2, 2}));
  ASSERT_EQ(coarse.around(0).size(), 1u);
  EXPECT_EQ(coarse.around(0)[0].cell, 1u);
  EXPECT_EQ(coarse.around(0)[0].edges, 2u);
  EXPECT_EQ(coarse.around(1)[0].edges, 2u);
}

TEST(GrowCells, JoinsNeighboursUpToTheLimit) {
  const ThreadPool pool(1);
  const FaceGraph graph = graph_of(strip(8), 10);
  const Coarsening pairs = grow_cells(graph, 2, 100, pool);
  EXPECT_EQ(contract(graph, pairs, pool).face_counts, (std::vector<uint32_t>{2, 2, 2, 2}));
  EXPECT_EQ(contract(graph, grow_cells(graph, 8, 3, pool), pool).face_counts, (std::vector<uint32_t>{3, 3, 2}));
  EXPECT_EQ(grow_cells(graph, 2, 1, pool).count, 8u);
  // And cells of those.
  EXPECT_EQ(contract(contract(graph, pairs, pool), grow_cells(contract(graph, pairs, pool), 2, 4, pool), pool)
                .face_counts,
            (std::vector<uint32_t>{4, 4}));
}

TEST(GrowCells, JoinsWhatIsLeftAloneToANeighbour) {
  const ThreadPool pool(1);
  // The first takes the middle one, which the others have for their only neighbour.
  const FaceGraph graph = graph_of({{0, 1, 3}, {1, 2, 4}, {2, 0, 5}, {0, 1, 2}}, 6);
  EXPECT_EQ(contract(graph, grow_cells(graph, 2, 4, pool), pool).face_counts, (std::vector<uint32_t>{4}));
  EXPECT_EQ(grow_cells(graph, 2, 3, pool).count, 2u);
}

// Stretches of the order are done at once, where neighbours are near each other in it.
TEST(GrowCells, DoesNotDependOnThreadsNorSuffersFromAnyOrder) {
  Faces faces = strip(200000);
  const Coarsening cells = grow_cells(graph_of(faces, 200002), 8, 100, ThreadPool(1));
  EXPECT_LE(cells.count, 200000u / 8 + 4);
  EXPECT_EQ(grow_cells(graph_of(faces, 200002), 8, 100, ThreadPool(2)).coarse_of, cells.coarse_of);
  std::shuffle(faces.begin(), faces.end(), std::mt19937(1));
  const FaceGraph shuffled = graph_of(faces, 200002);
  const Coarsening found = grow_cells(shuffled, 8, 100, ThreadPool(2));
  EXPECT_LE(found.count, 200000u / 4);
  EXPECT_EQ(grow_cells(shuffled, 8, 100, ThreadPool(1)).coarse_of, found.coarse_of);
}

}  // namespace
}  // namespace psplit
