// Refinement of jagged borders (paper, section 3.6), and of balance.
#pragma once

#include "encoder/partition/clusters.h"

namespace psplit {

// Faces on borders change sides. First a face that has two neighbours in another patch goes to it, the
// lower-numbered patch winning and a face between three patches staying: the paper's rule. Then, sweep by
// sweep, a face moves where fewer vertices are shared between patches after it, and among moves that change
// nothing where sizes come closer.
void refine_border(const Topology& topology, const Component& component, Clusters& clusters);

}  // namespace psplit
