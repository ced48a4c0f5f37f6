// Builds the stitch map: which stream owns each point, and how all other streams refer to it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/stitching/border_walk.h"
#include "src/parallel.h"

namespace psplit {

// A stream as its decoder returns it, with the mesh's point for each decoded point.
struct OwnedStream {
  std::vector<Face> faces;
  std::vector<uint32_t> points;  // mesh point of each decoded point
  bool is_residue = false;
};

struct Stitching {
  std::vector<std::vector<uint8_t>> maps;  // one per stream, as the container stores them
  std::vector<uint32_t> reference_counts;  // one per stream
  std::vector<uint32_t> source_point;      // mesh point of each point of the stitched mesh, in its order
};

// The first stream that uses a point owns it, at its first decoded point that is that point.
Stitching build_stitching(std::span<const OwnedStream> streams, uint32_t point_count, const ThreadPool& pool);

}  // namespace psplit
