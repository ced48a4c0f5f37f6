// Sums of hashes of triangles: whether two meshes of any size have the same triangles, in the memory of a few
// numbers.
//
// The hash of a triangle (128 bits) covers the values at its corners, beginning at its smallest corner, so that
// order, numbering and the first corner do not count, but the orientation does. Sums are modulo 2^128. Equal
// sums and counts show that the triangles are the same, each as often: for two different meshes that nobody
// constructed for it, the chance of equal sums is about 2^-128. Triangles with two equal positions do not
// count.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "gltf_ext/files/content_hash.h"
#include "gltf_ext/primitive/mesh_view.h"
#include "src/parallel.h"

namespace psplit {

struct TriangleSum {
  uint64_t low = 0, high = 0, count = 0;

  void add(const Hash128& hash);
  void add(const TriangleSum& other);
  bool operator==(const TriangleSum&) const = default;
};

struct PositionBox {
  std::array<float, 3> low{}, high{};
};

struct TriangleSums {
  static constexpr size_t kCells = 16;  // along each axis
  TriangleSum all;
  // By the position of the smallest corner, in a box that is divided equally. x changes fastest.
  std::vector<TriangleSum> cells = std::vector<TriangleSum>(kCells * kCells * kCells);
  uint64_t degenerate = 0;
};

// Only the values of `attributes` count, bit for bit, except for the sign of zero. Every mesh has all of them;
// the first is POSITION, of three floats. The memory of mapped files is released on the way. Errors:
// kInvalidInput if an index is not below the number of points.
Expected<TriangleSums> sum_triangles(std::span<const MeshView> meshes, std::span<const std::string> attributes,
                                     const PositionBox& box, const ThreadPool& pool);

// The smallest box around the positions. Values that are not finite do not count.
PositionBox position_box(std::span<const MeshView> meshes);

}  // namespace psplit
