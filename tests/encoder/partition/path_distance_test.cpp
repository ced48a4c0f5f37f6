#include "encoder/partition/path_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>

#include "tests/encoder/partition/pieces.h"

namespace psplit {
namespace {

using Faces = std::vector<std::array<uint32_t, 3>>;

// A flat rhomb of equilateral triangles, `size` edges a side; or the same with edges flipped, as if by chance.
Faces rhomb(uint32_t size, bool flips) {
  Faces faces;
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const uint32_t a = y * (size + 1) + x, b = a + 1, c = a + size + 1, d = c + 1;
      const bool flip = flips && (((x * 2654435761u) ^ (y * 2246822519u)) >> 7 & 1);
      faces.push_back(flip ? std::array{a, b, d} : std::array{a, b, c});
      faces.push_back(flip ? std::array{a, d, c} : std::array{b, d, c});
    }
  return faces;
}

// Where the centre of a face of the flat rhomb is, in edges.
std::array<double, 2> centre(const std::array<uint32_t, 3>& face, uint32_t size) {
  double x = 0, y = 0;
  for (const uint32_t v : face) {
    x += (v % (size + 1) + v / (size + 1) / 2.0) / 3;
    y += v / (size + 1) * std::sqrt(0.75) / 3;
  }
  return {x, y};
}

struct Measured {
  Measured(Faces all, uint32_t vertex_count, PathDistance kind)
      : faces(std::move(all)),
        graph(face_graph(faces, vertex_count, ThreadPool(1))),
        map(faces, vertex_count, graph, kind) {}

  std::vector<uint32_t> distances() const {
    std::vector<uint32_t> found;
    for (uint32_t face = 0; face < faces.size(); ++face) found.push_back(map.distance(face));
    return found;
  }

  Faces faces;
  FaceGraph graph;
  DistanceMap map;
};

TEST(DistanceMap, OfAStripIsCountedInEdgesAndSpokes) {
  Faces strip;
  for (uint32_t i = 0; i < 9; ++i) strip.push_back({i, i + 1, i + 2});
  Measured dijkstra(strip, 11, PathDistance::kDijkstra), geodesic(strip, 11, PathDistance::kGeodesic);
  for (Measured* measured : {&dijkstra, &geodesic}) measured->map.add(std::array{Source{0, 5, 0}});
  EXPECT_EQ(dijkstra.map.distance(0), 0u);
  EXPECT_EQ(dijkstra.map.distance(1), kSpokeLength);
  EXPECT_EQ(dijkstra.map.distance(2), 2 * kSpokeLength);
  EXPECT_EQ(dijkstra.map.distance(3), 3 * kSpokeLength);
  EXPECT_EQ(dijkstra.map.distance(8), 2 * kSpokeLength + 3 * kEdgeLength);
  EXPECT_EQ(geodesic.map.distance(0), 0u);
  EXPECT_NEAR(geodesic.map.distance(8), 4 * kEdgeLength, kEdgeLength / 3.0);
  for (uint32_t face = 0; face < 9; ++face) EXPECT_EQ(geodesic.map.nearest(face), 5u);
}

TEST(DistanceMap, OfAPlaneIsEuclids) {
  constexpr uint32_t kSize = 120;
  const uint32_t source = kSize * kSize + kSize;  // in the middle
  Measured dijkstra(rhomb(kSize, false), (kSize + 1) * (kSize + 1), PathDistance::kDijkstra);
  Measured geodesic(rhomb(kSize, false), (kSize + 1) * (kSize + 1), PathDistance::kGeodesic);
  for (Measured* measured : {&dijkstra, &geodesic}) measured->map.add(std::array{Source{source, 0, 0}});
  const auto [x0, y0] = centre(dijkstra.faces[source], kSize);
  for (uint32_t face = 0; face < dijkstra.faces.size(); ++face) {
    const auto [x, y] = centre(dijkstra.faces[face], kSize);
    const double straight = std::hypot(x - x0, y - y0) * kEdgeLength;
    const double along_edges = dijkstra.map.distance(face), across_faces = geodesic.map.distance(face);
    if (straight < 2 * kEdgeLength) continue;
    // Paths go in twelve directions, and so are longer by 1 / cos 15 degrees at most, but for their ends.
    EXPECT_GE(along_edges, straight - 1);
    EXPECT_LE(along_edges, straight * 1.0353 + 0.2 * kEdgeLength);
    // Marching takes fronts for straight, which near the source they are not.
    EXPECT_GE(across_faces, straight - 1);
    EXPECT_LE(across_faces, straight * 1.01 + 0.5 * kEdgeLength);
    EXPECT_LE(across_faces, along_edges * 1.01 + 0.5 * kEdgeLength);
  }
}

TEST(DistanceMap, UpdatedLocallyIsThatMadeAnew) {
  std::vector<Source> sources;
  for (uint32_t i = 0; i < 60; ++i) sources.push_back({i * 7919 % 3200, i, i / 10 * 50});
  for (const PathDistance kind : kDistances) {
    Measured at_once(rhomb(40, true), 41 * 41, kind), in_turn(rhomb(40, true), 41 * 41, kind);
    at_once.map.add(sources);
    for (const Source& source : sources) in_turn.map.add({&source, 1});
    EXPECT_EQ(at_once.distances(), in_turn.distances());
    in_turn.map.clear();
    EXPECT_EQ(in_turn.map.distance(0), kUnreached);
    for (size_t i = sources.size(); i-- > 0;) in_turn.map.add({&sources[i], 1});
    EXPECT_EQ(at_once.distances(), in_turn.distances());
  }
}

TEST(DistanceMap, NamesASourceThatIsNearly) {
  for (const PathDistance kind : kDistances) {
    Measured all(rhomb(40, true), 41 * 41, kind);
    std::deque<Measured> alone;
    for (uint32_t i = 0; i < 5; ++i) {
      const Source source{i * 700, i, 0};
      all.map.add({&source, 1});
      alone.emplace_back(rhomb(40, true), 41 * 41, kind).map.add({&source, 1});
    }
    for (uint32_t face = 0; face < all.faces.size(); ++face)
      EXPECT_LE(alone[all.map.nearest(face)].map.distance(face), all.map.distance(face) + kEdgeLength);
  }
}

TEST(DistanceMap, GoesAcrossVerticesAndNotBetweenComponents) {
  for (const PathDistance kind : kDistances) {
    Measured measured({{0, 1, 2}, {2, 3, 4}, {5, 6, 7}, {4, 4, 4}, {4, 4, 3}}, 8, kind);
    measured.map.add(std::array{Source{0, 0, 0}});
    EXPECT_NEAR(measured.map.distance(1), 2 * kSpokeLength, kSpokeLength / 2.0);
    EXPECT_EQ(measured.map.distance(2), kUnreached);
    EXPECT_NE(measured.map.distance(3), kUnreached);
    EXPECT_NE(measured.map.distance(4), kUnreached);
  }
}

}  // namespace
}  // namespace psplit
