// Clustering of faces around centres, and centres around clusters (paper, section 3.5).
#pragma once

#include "encoder/partition/topology.h"

namespace psplit {

// The patches of one component while they take shape. Arrays by face and by vertex span the whole mesh.
struct Clusters {
  std::vector<uint32_t>& patch_of_face;  // from `base` on
  uint32_t base = 0;
  std::vector<uint32_t> centres;  // a face per patch
  std::vector<uint32_t> weights;  // head starts, in quarters of a step: the heavier, the later a patch starts
  std::vector<uint32_t> sizes;    // faces per patch
};

// Each face goes to the centre from which the fewest steps lead to it (from face to vertex to face: Dijkstra's
// distance on the graph of face centres and vertices), weights added.
void assign_to_centres(const Topology& topology, const Component& component, Clusters& clusters);

// Each centre moves to the face deepest inside its patch, and weights change so that large patches shrink.
void relax_centres(const Topology& topology, const Component& component, Clusters& clusters, double gain);

}  // namespace psplit
