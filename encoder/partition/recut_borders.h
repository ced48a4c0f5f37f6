// Replaces borders between patches by minimum cuts.
#pragma once

#include "encoder/partition/cell_graph.h"

namespace psplit {

struct RecutOptions {
  int rounds = 1;
  // The width of the band along a border: the faces on each side, divided by those for which the other side has
  // room. Wider bands give shorter borders, but more of these are out of balance and must be tried again in
  // narrower bands.
  double band = 1;
};

// For each two neighbouring patches, a minimum cut (band_cut.h) divides a band of cells along their border: no
// other border inside the band is shorter. Of equally short borders the better balanced one is used. Connected
// patches stay connected. No patch grows above its limit of faces, and patches above their limit shrink. Pairs
// that share no patch are processed in parallel; the result does not depend on the number of threads.
void recut_borders(const FaceGraph& graph, std::span<const uint32_t> face_limits, const RecutOptions& options,
                   std::vector<uint32_t>& patch_of, const ThreadPool& pool);
void recut_borders(const CellGraph& graph, std::span<const uint32_t> face_limits, const RecutOptions& options,
                   std::vector<uint32_t>& patch_of, const ThreadPool& pool);

}  // namespace psplit
