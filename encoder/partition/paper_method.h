// The paper's own method (sections 3.4 and 3.5): farthest-point samples, a cluster of faces around each, and
// clusters grouped to patches by k-means.
#pragma once

#include "encoder/partition/cells.h"
#include "encoder/partition/halve_sets.h"
#include "encoder/partition/path_distance.h"

namespace psplit {

// Faces, each as far as can be from those before it: `count` of them, but at least one in each connected
// component and at most all. The map has no sources yet; it gets the samples, numbered in their order.
std::vector<uint32_t> sample_faces(DistanceMap& map, uint32_t face_count, uint32_t count);

// Cells of faces, each connected by edges.
struct Clusters {
  std::vector<uint32_t> cell_of;  // one per face
  std::vector<uint32_t> centres;  // one face per cell
};

// Every face to its nearest sample, or to a neighbour's where it is cut off from that one. Cells are numbered
// as samples are. A component that hangs on others by vertices, and that no sample fell in, is a cell more.
Clusters cluster_faces(const DistanceMap& map, const FaceGraph& faces, std::vector<uint32_t> samples);

// The patch of every face. Sets of cells get theirs by k-means: cells go to the nearest of so many centres,
// which move to the middle of their cells, and start late where they have too many faces, early where too few;
// then faces go to the nearest of those centres. At first centres are a set's cells of the lowest numbers. A
// set with no more cells than patches gives each cell a patch, and leaves patches empty. `cells` is the face
// graph contracted; the map has the samples, and gets the centres.
std::vector<uint32_t> group_clusters(DistanceMap& map, const FaceGraph& faces, const Clusters& clusters,
                                     const CellGraph& cells, std::span<const PatchSet> sets);

}  // namespace psplit
