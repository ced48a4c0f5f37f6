// Greedy geodesic farthest-point sampling on the topology model (paper, section 3.4).
#pragma once

#include "encoder/partition/topology.h"

namespace psplit {

// Up to `count` vertices of the component, each as far as can be from those before it, in steps along edges.
// After every sample the map of distances is updated where the new sample is nearer, and only there. Fewer are
// returned when the component has no vertex left that is not a sample. `distance` is scratch, one per vertex of
// the mesh.
std::vector<uint32_t> farthest_points(const Topology& topology, const Component& component, uint32_t count,
                                      std::vector<uint32_t>& distance);

}  // namespace psplit
