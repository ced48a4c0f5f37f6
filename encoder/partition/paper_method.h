// The paper's own method (sections 3.4 and 3.5): farthest-point samples, a cluster of faces around each sample,
// and k-means, which groups the clusters to patches.
#pragma once

#include "encoder/partition/partition_steps.h"
#include "encoder/partition/path_distance.h"

namespace psplit {

// `count` faces, each as far as possible from those before it; but at least one in each connected component,
// and at most all. `map` has no sources yet. The samples become its sources, numbered in their order.
std::vector<uint32_t> sample_faces(DistanceMap& map, uint32_t face_count, uint32_t count);

// Cells of faces, each connected by edges.
struct Clusters {
  std::vector<uint32_t> cell_of;  // one per face
  std::vector<uint32_t> centres;  // one face per cell
};

// Assigns every face to its nearest sample, or to a neighbour's sample if other cells cut it off from the
// nearest. Cells have the numbers of their samples. A component that touches others only at vertices, and has
// no sample, becomes an extra cell.
Clusters cluster_faces(const DistanceMap& map, const FaceGraph& faces, std::vector<uint32_t> samples);

// The patch of every face, by k-means in each set of cells. A set has as many centres as patches, at first its
// cells with the lowest numbers. Cells go to the nearest centre; centres move to the middle of their cells. A
// patch with too many faces starts to grow later, one with too few earlier. In the end, faces go to the nearest
// centre. If a set has no more cells than patches, each cell is a patch, and the other patches are empty.
// `cells` is the contracted face graph. The sources of `map` are the samples; the centres replace them.
std::vector<uint32_t> group_clusters(DistanceMap& map, const FaceGraph& faces, const Clusters& clusters,
                                     const CellGraph& cells, std::span<const PatchSet> sets);

}  // namespace psplit
