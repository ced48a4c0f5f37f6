// Cuts the faces of a mesh into balanced, compact patches by connectivity alone.
//
// Source: Zhao, Tang, Tong: Connectivity-Based Segmentation for GPU-Accelerated Mesh Decompression, 2012,
// sections 3 and 4. Positions are dropped and every edge has length 1. Faces are clustered in several levels,
// and borders are refined. The levels follow Karypis and Kumar: A Fast and High Quality Multilevel Scheme for
// Partitioning Irregular Graphs, 1998. Faces are grouped into larger and larger cells, the largest cells into
// patches. Then the borders are refined, from the largest cells down to single faces.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "psplit/base.h"
#include "psplit/encode.h"
#include "psplit/parallel.h"

namespace psplit {

// The faces that a container can have.
inline constexpr uint32_t kMostFacesToCut = 0xffffffffu / 3;

struct PartitionOptions {
  uint32_t patch_count = 1;  // a target: 0 means 1; with more patches than faces, each face is a patch
  // False keeps the jagged borders of plain clustering, the paper's "unprocessed" row.
  bool refine = true;
  PartitionMethod method = PartitionMethod::kMultilevel;
  PathDistance distance = PathDistance::kDijkstra;
};

struct Partition {
  uint32_t patch_count = 0;             // every patch in [0, patch_count) has at least one face
  std::vector<uint32_t> patch_of_face;  // one per face
  // The face across each side of a face, from vertex c to the next, or 0xffffffff. Empty if they were not
  // searched, or some edge has more than two faces.
  std::vector<std::array<uint32_t, 3>> neighbours;
};

// `faces` has corner-table vertices (welded by position), each below vertex_count, and at most kMostFacesToCut.
// Any topology is allowed: several components, non-manifold edges, degenerate and repeated faces. The faces of
// a patch are connected by edges, unless whole components were packed into it. The result depends only on the
// input and the options, never on the number of threads. Two calls may share one pool.
Partition partition_faces(Span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count,
                          const PartitionOptions& options, const ThreadPool& pool);
// An overload that frees the faces as early as possible.
Partition partition_faces(std::vector<std::array<uint32_t, 3>>&& faces, uint32_t vertex_count,
                          const PartitionOptions& options, const ThreadPool& pool);

// Divides `patch_count` patches between objects (the paper's section 4.3). An object with M of the S faces gets
// floor(M x patch_count / S) patches, but at least one.
std::vector<uint32_t> distribute_patches(Span<const uint64_t> face_counts, uint64_t patch_count);

}  // namespace psplit
