// Borders between patches drawn anew, each as short as can be.
#pragma once

#include "encoder/partition/cell_graph.h"

namespace psplit {

struct RecutOptions {
  int rounds = 1;
  // How wide a band along a border is looked at: faces on either side, by those that the other side has room
  // for. Wider bands have shorter borders, of which more are out of balance and must be tried again in less.
  double band = 1;
};

// Between each two patches, a band of cells along their border is divided by a least cut (band_cut.h): no other
// border within the band is shorter. Of equal ones the better balanced is taken. Connected patches stay
// connected, none rises above its limit of faces, and those above sink. Pairs without a patch in common are
// done at once; the result does not depend on the number of threads.
void recut_borders(const FaceGraph& graph, std::span<const uint32_t> face_limits, const RecutOptions& options,
                   std::vector<uint32_t>& patch_of, const ThreadPool& pool);
void recut_borders(const CellGraph& graph, std::span<const uint32_t> face_limits, const RecutOptions& options,
                   std::vector<uint32_t>& patch_of, const ThreadPool& pool);

}  // namespace psplit
