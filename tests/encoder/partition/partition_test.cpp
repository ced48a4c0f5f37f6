#include "encoder/partition/partition.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

#include "tests/encoder/partition/pieces.h"

namespace psplit {
namespace {

using Faces = std::vector<std::array<uint32_t, 3>>;

// width x height quads, two triangles each; closed to a torus where `wraps`.
Faces sheet(uint32_t width, uint32_t height, bool wraps) {
  Faces faces;
  const uint32_t columns = wraps ? width : width + 1, rows = wraps ? height : height + 1;
  const auto vertex = [&](uint32_t x, uint32_t y) { return y % rows * columns + x % columns; };
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const uint32_t a = vertex(x, y), b = vertex(x + 1, y), c = vertex(x + 1, y + 1), d = vertex(x, y + 1);
      // Diagonals go either way, as if by chance: valences of 4 to 8.
      const bool flip = ((x * 2654435761u) ^ (y * 2246822519u)) >> 7 & 1;
      faces.push_back(flip ? std::array{a, b, d} : std::array{a, b, c});
      faces.push_back(flip ? std::array{b, c, d} : std::array{a, c, d});
    }
  return faces;
}

uint32_t vertex_count(const Faces& faces) {
  uint32_t count = 0;
  for (const auto& face : faces) count = std::max(count, *std::max_element(face.begin(), face.end()) + 1);
  return count;
}

Partition cut(const Faces& faces, uint32_t patch_count, int threads = 2, PartitionOptions options = {}) {
  options.patch_count = patch_count;
  return partition_faces(faces, vertex_count(faces), options, ThreadPool(threads));
}

PartitionOptions unrefined(PartitionOptions options = {}) {
  options.refine = false;
  return options;
}

PartitionOptions paper(PathDistance distance) {
  const PartitionOptions options{.method = PartitionMethod::kPaper, .distance = distance};
  return options;
}

std::vector<size_t> sizes(const Partition& partition) {
  std::vector<size_t> sizes(partition.patch_count);
  for (const uint32_t patch : partition.patch_of_face) ++sizes.at(patch);
  return sizes;
}

double balance(const Partition& partition) {
  const std::vector<size_t> all = sizes(partition);
  const double mean = static_cast<double>(partition.patch_of_face.size()) / static_cast<double>(all.size());
  return static_cast<double>(*std::max_element(all.begin(), all.end())) / mean;
}

double replication(const Faces& faces, const Partition& partition) {
  std::set<std::pair<uint32_t, uint32_t>> uses;
  std::set<uint32_t> vertices;
  for (size_t i = 0; i < faces.size(); ++i)
    for (const uint32_t v : faces[i]) {
      uses.insert({partition.patch_of_face[i], v});
      vertices.insert(v);
    }
  return static_cast<double>(uses.size()) / static_cast<double>(vertices.size()) - 1.0;
}

// Pieces that the patches consist of, faces being joined by edges.
size_t piece_count(const Faces& faces, const Partition& partition) {
  std::vector<uint32_t> parent(faces.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](uint32_t f) {
    while (parent[f] != f) f = parent[f] = parent[parent[f]];
    return f;
  };
  std::map<std::array<uint32_t, 3>, uint32_t> seen;  // edge and patch, to a face
  size_t pieces = faces.size();
  for (uint32_t i = 0; i < faces.size(); ++i)
    for (size_t c = 0; c < 3; ++c) {
      const auto [low, high] = std::minmax(faces[i][c], faces[i][(c + 1) % 3]);
      const uint32_t a = root(seen.try_emplace({low, high, partition.patch_of_face[i]}, i).first->second),
                     b = root(i);
      if (a != b) --pieces;
      parent[a] = b;
    }
  return pieces;
}

TEST(Partition, IsBalancedConnectedAndCompactOnALargeSheet) {
  const Faces faces = sheet(260, 200, true);  // 104,000 faces
  struct Expected {
    uint32_t faces_a_patch;
    double replication;  // 2 % above what was measured
  };
  for (const auto& [faces_a_patch, expected] :
       {Expected{4800, 0.0395}, Expected{1200, 0.0783}, Expected{440, 0.1323}}) {
    SCOPED_TRACE(faces_a_patch);
    const auto wanted = static_cast<uint32_t>(faces.size() / faces_a_patch);
    const Partition partition = cut(faces, wanted);
    EXPECT_EQ(partition.patch_count, wanted);
    EXPECT_LE(balance(partition), 1.05);
    EXPECT_LE(replication(faces, partition), expected);
    EXPECT_EQ(piece_count(faces, partition), wanted);
  }
}

TEST(Partition, OfThePaperIsBalancedConnectedAndCompactOnALargeSheet) {
  const Faces faces = sheet(260, 200, true);  // 104,000 faces
  struct Expected {
    uint32_t faces_a_patch;
    double replication;  // 2 % above what was measured
  };
  for (const PathDistance distance : kDistances)
    for (const auto& [faces_a_patch, expected] :
         {Expected{4800, 0.0383}, Expected{1200, 0.0769}, Expected{440, 0.1278}}) {
      SCOPED_TRACE(faces_a_patch);
      const auto wanted = static_cast<uint32_t>(faces.size() / faces_a_patch);
      const Partition partition = cut(faces, wanted, 2, paper(distance));
      EXPECT_EQ(partition.patch_count, wanted);
      EXPECT_LE(balance(partition), 1.05);
      EXPECT_LE(replication(faces, partition), expected);
      EXPECT_EQ(piece_count(faces, partition), wanted);
    }
}

TEST(Partition, OfThePaperNeedsNoRefinementToBeNearlyBalanced) {
  const Faces faces = sheet(260, 200, true);
  for (const PathDistance distance : kDistances)
    for (const uint32_t count : {20u, 85u, 230u})
      EXPECT_LE(balance(cut(faces, count, 2, unrefined(paper(distance)))), 1.6) << count << " patches";
}

TEST(Partition, RefinementLowersReplication) {
  const Faces faces = sheet(120, 100, true);
  for (const PartitionOptions& options :
       {PartitionOptions{}, paper(PathDistance::kDijkstra), paper(PathDistance::kGeodesic)})
    EXPECT_LT(replication(faces, cut(faces, 20, 2, options)),
              replication(faces, cut(faces, 20, 2, unrefined(options))));
}

TEST(Partition, DoesNotDependOnThreads) {
  Faces faces = sheet(200, 150, true);
  const uint32_t offset = vertex_count(faces);
  for (auto face : sheet(40, 70, false))
    faces.push_back({face[0] + offset, face[1] + offset, face[2] + offset});
  for (const PartitionOptions& options :
       {PartitionOptions{}, paper(PathDistance::kDijkstra), paper(PathDistance::kGeodesic)}) {
    const Partition one = cut(faces, 40, 1, options);
    for (const int threads : {2, 3, 7})
      EXPECT_EQ(one.patch_of_face, cut(faces, 40, threads, options).patch_of_face);
  }
}

TEST(Partition, FreesFacesThatItIsGiven) {
  const Faces faces = sheet(30, 20, true);
  for (PartitionOptions options : {PartitionOptions(), paper(PathDistance::kDijkstra)}) {
    options.patch_count = 7;
    const Partition expected = cut(faces, 7, 2, options);
    Faces given = faces;
    const Partition partition = partition_faces(std::move(given), vertex_count(faces), options, ThreadPool(2));
    EXPECT_EQ(partition.patch_of_face, expected.patch_of_face);
    EXPECT_EQ(partition.patch_count, expected.patch_count);
    EXPECT_EQ(given.capacity(), 0u);
  }
}

TEST(Partition, TakesAnyCount) {
  const Faces faces = sheet(5, 4, false);
  EXPECT_EQ(cut(faces, 0).patch_count, 1u);
  EXPECT_EQ(cut(faces, 1).patch_count, 1u);
  EXPECT_EQ(cut(faces, 40).patch_count, 40u);
  EXPECT_EQ(cut(faces, 4000000000u).patch_count, 40u);
  for (uint32_t count = 2; count < 40; ++count)
    for (const PartitionOptions& options :
         {PartitionOptions{}, paper(PathDistance::kDijkstra), paper(PathDistance::kGeodesic)})
      for (const size_t size : sizes(cut(faces, count, 2, options))) EXPECT_GT(size, 0u) << count;
}

TEST(Partition, TakesAnyTopology) {
  EXPECT_EQ(cut({}, 3).patch_count, 0u);
  EXPECT_EQ(cut({{0, 1, 2}}, 3).patch_count, 1u);
  Faces book, loose, repeated(50, {0, 1, 2}), degenerate = {{0, 0, 0}, {0, 0, 1}, {1, 2, 2}, {3, 4, 5}};
  for (uint32_t i = 0; i < 50; ++i) book.push_back({0, 1, i + 2});
  for (uint32_t i = 0; i < 1000; ++i) loose.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  // Two sheets and a face that have nothing but a vertex in common.
  Faces hanging = sheet(12, 12, false);
  const uint32_t last = vertex_count(hanging) - 1;
  for (const auto& face : sheet(9, 9, false))
    hanging.push_back({face[0] + last, face[1] + last, face[2] + last});
  hanging.push_back({last, 900, 901});
  std::vector<PartitionOptions> all{{}};
  for (const PathDistance distance : kDistances) all.push_back(paper(distance));
  for (const PartitionOptions& options : all) {
    for (const Faces& faces : {book, loose, repeated, degenerate, hanging})
      for (const uint32_t count : {1u, 2u, 3u, 7u}) {
        const Partition partition = cut(faces, count, 2, options);
        ASSERT_EQ(partition.patch_of_face.size(), faces.size());
        EXPECT_GE(partition.patch_count, 1u);
        for (const size_t size : sizes(partition)) EXPECT_GT(size, 0u);
      }
    EXPECT_LE(cut(loose, 10, 2, options).patch_count, 11u);
    EXPECT_LE(balance(cut(loose, 10, 2, options)), 1.30);
  }
}

TEST(Partition, SplitsAComponentThatWouldBeTooLarge) {
  // Components of 1.4 shares, and of a little less than one.
  Faces faces = sheet(14, 10, false);
  for (int i = 0; i < 4; ++i) {
    const uint32_t offset = vertex_count(faces);
    for (auto face : sheet(9, 10, false))
      faces.push_back({face[0] + offset, face[1] + offset, face[2] + offset});
  }
  const Partition partition = cut(faces, 5);
  EXPECT_EQ(partition.patch_count, 6u);
  EXPECT_LE(balance(partition), 1.10);
}

TEST(DistributePatches, FollowsThePapersRule) {
  const std::vector<uint64_t> faces = {100, 250, 650, 1};
  EXPECT_EQ(distribute_patches(faces, 10), (std::vector<uint32_t>{1, 2, 6, 1}));
  EXPECT_EQ(distribute_patches(faces, 0), (std::vector<uint32_t>{1, 1, 1, 1}));
  EXPECT_EQ(distribute_patches(std::vector<uint64_t>{0, 0}, 5), (std::vector<uint32_t>{1, 1}));
  const std::vector<uint64_t> exact = {1, 2, 3};
  EXPECT_EQ(distribute_patches(exact, 6), (std::vector<uint32_t>{1, 2, 3}));
}

}  // namespace
}  // namespace psplit
