// What becomes an Edgebreaker stream, and what comes of it.
#pragma once

#include <array>
#include <cstdint>
#include <numeric>
#include <vector>

#include "psplit/mesh.h"

namespace psplit {

// A part of a welded mesh. Its points have numbers of their own, from 0.
struct PatchMesh {
  static constexpr uint32_t kNoFace = 0xffffffffu;

  std::vector<uint32_t> points;                // points of the mesh
  std::vector<std::array<uint32_t, 3>> faces;  // indices into `points`
  // If not empty, the points of the mesh whose values are stored in place of the values of `points`.
  std::vector<uint32_t> value_points;
  // If not empty: for each face and side, from corner c to the next, the only other face with the edge, or
  // kNoFace.
  std::vector<std::array<uint32_t, 3>> neighbours{};

  const std::vector<uint32_t>& points_of_values() const { return value_points.empty() ? points : value_points; }
};

// All of a mesh as a patch.
inline PatchMesh whole_mesh(const Mesh& mesh) {
  PatchMesh whole;
  whole.points.resize(mesh.point_count);
  std::iota(whole.points.begin(), whole.points.end(), 0u);
  whole.faces.assign(mesh.faces.begin(), mesh.faces.end());
  return whole;
}

// An Edgebreaker stream, and what it decodes to.
struct EncodedPatch {
  std::vector<uint8_t> bytes;
  size_t table_bytes = 0;  // of tables of probabilities, among the bytes
  // The faces and points in the order of the stream. It has attributes only if the caller wants their values.
  Mesh decoded;
  // For each decoded point the patch's point. A point occurs more than once if Edgebreaker has to split it.
  std::vector<uint32_t> patch_point;
  std::vector<uint32_t> walk;  // of its border, by decoded points (border_walk), unless the caller wants values
};

}  // namespace psplit
