#include "encoder/partition/paper_method.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "tests/encoder/partition/pieces.h"

namespace psplit {
namespace {

using Faces = std::vector<std::array<uint32_t, 3>>;

// width x height quads, two triangles each, from vertex `first` on.
Faces sheet(uint32_t width, uint32_t height, uint32_t first = 0) {
  Faces faces;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const uint32_t a = first + y * (width + 1) + x, b = a + 1, c = a + width + 1, d = c + 1;
      faces.push_back({a, b, d});
      faces.push_back({a, d, c});
    }
  return faces;
}

struct Surface {
  explicit Surface(Faces all) : faces(std::move(all)) {
    for (const auto& face : faces)
      vertex_count = std::max(vertex_count, *std::max_element(face.begin(), face.end()) + 1);
    graph = face_graph(faces, vertex_count, ThreadPool(1));
  }
  uint32_t face_count() const { return static_cast<uint32_t>(faces.size()); }
  DistanceMap map(PathDistance kind) const { return {faces, vertex_count, graph, kind}; }

  Faces faces;
  uint32_t vertex_count = 0;
  FaceGraph graph;
};

// Sheets side by side, one that hangs on the first by a vertex, and a face of the same.
Surface several_components() {
  Faces faces = sheet(20, 15);
  const uint32_t last = 21 * 16 - 1;
  for (const Faces& more :
       {sheet(6, 6, last), sheet(30, 2, 1000), Faces{{0, 2000, 2001}}, Faces{{3000, 3001, 3002}}})
    faces.insert(faces.end(), more.begin(), more.end());
  return Surface(faces);
}

TEST(SampleFaces, AreEachTheFarthestFromThoseBefore) {
  const Surface surface(sheet(40, 25));
  for (const PathDistance kind : kDistances) {
    DistanceMap map = surface.map(kind), again = surface.map(kind);
    const std::vector<uint32_t> samples = sample_faces(map, surface.face_count(), 100);
    ASSERT_EQ(samples.size(), 100u);
    for (uint32_t i = 0; i < samples.size(); ++i) {
      uint32_t farthest = 0;
      for (uint32_t face = 0; face < surface.face_count(); ++face)
        farthest = std::max(farthest, again.distance(face));
      EXPECT_EQ(again.distance(samples[i]), farthest);
      again.add(std::array{Source{samples[i], i, 0}});
    }
    for (uint32_t face = 0; face < surface.face_count(); ++face)
      EXPECT_EQ(map.distance(face), again.distance(face));
  }
}

TEST(SampleFaces, AreOneInEachComponentAndAtMostAllFaces) {
  const Surface surface(Faces{{0, 1, 2}, {1, 2, 3}, {1, 2, 3}, {4, 5, 6}, {7, 7, 7}, {7, 7, 8}});
  for (const PathDistance kind : kDistances) {
    DistanceMap few = surface.map(kind), many = surface.map(kind);
    EXPECT_EQ(sample_faces(few, 6, 1), (std::vector<uint32_t>{0, 3, 4}));
    const std::vector<uint32_t> all = sample_faces(many, 6, 100);
    EXPECT_EQ(all.size(), 6u);
    EXPECT_EQ(std::set<uint32_t>(all.begin(), all.end()).size(), 6u);
  }
}

TEST(ClusterFaces, TakesEveryFaceToAConnectedCell) {
  const Surface surface = several_components();
  for (const PathDistance kind : kDistances)
    for (const uint32_t count : {1u, 7u, 60u}) {
      DistanceMap map = surface.map(kind);
      const std::vector<uint32_t> samples = sample_faces(map, surface.face_count(), count);
      const Clusters clusters = cluster_faces(map, surface.graph, samples);
      EXPECT_TRUE(std::equal(samples.begin(), samples.end(), clusters.centres.begin()));
      for (uint32_t cell = 0; cell < clusters.centres.size(); ++cell)
        EXPECT_EQ(clusters.cell_of[clusters.centres[cell]], cell);
      EXPECT_EQ(piece_count(surface.graph, clusters.cell_of), clusters.centres.size());
    }
}

TEST(GroupClusters, MakesConnectedPatchesOfNearlyOneSize) {
  const Surface surface(sheet(60, 50));
  std::vector<uint32_t> all(8 * 16);
  std::iota(all.begin(), all.end(), 0u);
  for (const PathDistance kind : kDistances) {
    DistanceMap map = surface.map(kind);
    const Clusters clusters =
        cluster_faces(map, surface.graph, sample_faces(map, surface.face_count(), 8 * 16));
    const CellGraph cells = contract(surface.graph, {clusters.cell_of, 8 * 16}, ThreadPool(1));
    const std::vector<uint32_t> patch_of =
        group_clusters(map, surface.graph, clusters, cells, std::array{PatchSet{all, 3, 8}});
    for (uint32_t patch = 3; patch < 11; ++patch)
      EXPECT_NEAR(static_cast<double>(std::count(patch_of.begin(), patch_of.end(), patch)), 750.0, 110.0);
    EXPECT_EQ(piece_count(surface.graph, patch_of), 8u);
  }
}

}  // namespace
}  // namespace psplit
