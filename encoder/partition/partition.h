// Cuts the faces of a mesh into balanced, compact patches by connectivity alone.
//
// Zhao, Tang, Tong: Connectivity-Based Segmentation for GPU-Accelerated Mesh Decompression, 2012, sections 3
// and 4: positions are dropped, every edge has length 1; faces are clustered in several levels; borders are
// refined. The levels are those of Karypis and Kumar: A Fast and High Quality Multilevel Scheme for
// Partitioning Irregular Graphs, 1998: cells of ever more faces, patches of the largest cells, then refinement
// from the largest cells down to single faces.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "src/parallel.h"

namespace psplit {

enum class PartitionMethod {
  kMultilevel,  // cells of neighbours, and of those; cut in halves, borders drawn anew from level to level
  kPaper,       // farthest-point samples, clusters of faces around them, k-means of those
};

// How the paper's method measures from face to face.
enum class PathDistance {
  kDijkstra,  // shortest paths along edges, and over the centres of faces
  kGeodesic,  // fast marching, straight across faces
};

struct PartitionOptions {
  uint32_t patch_count = 1;  // a target: 0 counts as 1, more than the faces as one face a patch
  // Off leaves the jagged borders of plain clustering: the paper's "unprocessed" row.
  bool refine = true;
  PartitionMethod method = PartitionMethod::kMultilevel;
  PathDistance distance = PathDistance::kDijkstra;
  // N of the paper's M x N samples for M patches. 1 is its single level, where clusters are patches, and
  // balance is left to refinement.
  uint32_t samples_per_patch = 16;
};

struct Partition {
  uint32_t patch_count = 0;             // every patch in [0, patch_count) has at least one face
  std::vector<uint32_t> patch_of_face;  // one per face
};

// `faces` are corner-table vertices (welded by position), each below vertex_count. Any topology is taken:
// several components, non-manifold edges, degenerate and repeated faces. The faces of a patch are connected by
// edges, unless whole components were packed into it. The result depends on the input and the options only,
// never on the number of threads. Two calls may share one pool.
Partition partition_faces(std::span<const std::array<uint32_t, 3>> faces, uint32_t vertex_count,
                          const PartitionOptions& options, const ThreadPool& pool);

// The paper's section 4.3: of `patch_count` patches over all objects, an object of M of the S faces gets
// floor(M x patch_count / S), and at least one.
std::vector<uint32_t> distribute_patches(std::span<const uint64_t> face_counts, uint64_t patch_count);

}  // namespace psplit
