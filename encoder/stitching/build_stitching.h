// Builds the stitch map: who owns each point, and how every other use of it refers to the owner.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/stitching/border_walk.h"
#include "src/parallel.h"

namespace psplit {

// A stream as its decoder will see it, with the mesh's point behind each of its decoded points.
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

// The owner of a point is the first stream that uses it, at the first decoded point that is it.
Stitching build_stitching(std::span<const OwnedStream> streams, uint32_t point_count, const ThreadPool& pool);

}  // namespace psplit
