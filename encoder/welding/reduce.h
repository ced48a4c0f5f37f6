// The part of a mesh that is stored: without duplicate points, degenerate faces and unused points.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "encoder/welding/weld.h"
#include "psplit/mesh.h"
#include "psplit/parallel.h"

namespace psplit {

struct ReduceOptions {
  bool keep_duplicates = false;  // keep points apart that are equal in everything
  bool drop_degenerate = false;  // drop faces that repeat an index; they draw nothing
  bool drop_unused = false;      // drop points that no face uses
  // Points that are equal in these bytes are merged, too, if that makes no face degenerate and gives no edge a
  // third face.
  ComparedBytes compared{};
  bool leaves_unchanged = false;  // make no copy of a mesh that stays as it is
};

struct ReducedMesh {
  Mesh mesh;                           // empty if nothing is merged or dropped and options.leaves_unchanged
  std::vector<uint32_t> source_point;  // for each of its points, the point of the input
  uint64_t merged_points = 0;
  uint64_t dropped_faces = 0;
  uint64_t dropped_points = 0;
  bool differ_in_positions = false;  // it is known that no two of its points have the same position

  // Whether the mesh is the input.
  bool is_unchanged() const { return merged_points + dropped_faces + dropped_points == 0; }
};

// Whether two of the face's points are the same.
inline bool repeats_a_point(const std::array<uint32_t, 3>& face) {
  return face[0] == face[1] || face[1] == face[2] || face[2] == face[0];
}

// Points and faces keep their order; each group of equal points becomes its lowest. `extra` holds
// `extra_stride` more bytes for each point: points that differ there are not duplicates. Every index must be
// below mesh.point_count.
ReducedMesh reduce(const Mesh& mesh, const ReduceOptions& options, const ThreadPool& pool,
                   std::span<const std::byte> extra = {}, size_t extra_stride = 0);

// For each point 1 if reduce() stores its values, otherwise 0. Takes much less time than reduce().
std::vector<uint8_t> stored_points(const Mesh& mesh, const ReduceOptions& options, const ThreadPool& pool,
                                   std::span<const std::byte> extra = {}, size_t extra_stride = 0);

}  // namespace psplit
