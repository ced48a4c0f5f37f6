// Builds the stitch map: which stream owns each point, and how all other streams refer to it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/stitching/stitch_map.h"
#include "psplit/parallel.h"

namespace psplit {

// A stream as its decoder returns it.
struct OwnedStream {
  std::vector<uint32_t> points;  // the mesh's point for each decoded point
  std::vector<uint32_t> walk;    // its border (border_walk); none of the residue
};

// The stream that owns a point of the mesh.
struct PointOwner {
  static constexpr uint32_t kNone = 0xffffffffu;

  uint32_t stream = kNone;
  uint32_t point = 0;           // decoded point of the stream
  uint32_t rank = 0;            // number among the points that the stream owns
  uint32_t walk_place = kNone;  // place in the stream's border walk
};

struct Stitching {
  std::vector<std::vector<uint8_t>> maps;  // one per stream, as the container stores them
  std::vector<uint32_t> reference_counts;  // one per stream
  std::vector<uint32_t> source_point;      // mesh point of each point that the streams own, in their order
};

// `streams` are a container's streams from `first_stream` on. The first stream that uses a point owns it, at
// its first decoded point that is that point. `owners` has an element for each point of the mesh. It comes with
// the owners among earlier streams, and returns with all.
Stitching build_stitching(std::span<const OwnedStream> streams, uint32_t first_stream,
                          std::span<PointOwner> owners, const ThreadPool& pool);

}  // namespace psplit
