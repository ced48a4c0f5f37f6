// The stitch map: which points of a patch belong to another patch, and which points those are.
//
// Every point of the mesh has one owner: the lowest-numbered patch that uses it. A patch numbers the points
// that it owns consecutively, in the order of its decoded points. Its other decoded points are references.
// Nearly all of them are on the patch's border, where the neighbour walks the same border backwards. So most
// references are stored as runs over both walks (border_walk.h):
//
//        patch p  ... a  b  c  d ...   walk of p, forwards
//        -------------o--o--o--o----   the cut
//        patch q  ... a  b  c  d ...   walk of q, backwards
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/container/patch_container.h"

namespace psplit {

// `length` consecutive points of this patch's walk, from `begin` on, are points of the walk of patch `owner`:
// from `start` downwards, or upwards if `forward` holds.
struct StitchRun {
  uint32_t begin = 0;
  uint32_t length = 0;
  uint32_t owner = 0;
  uint32_t start = 0;
  bool forward = false;
  bool operator==(const StitchRun&) const = default;
};

// Decoded point `point` of this patch is the same as its decoded point `target`, which comes earlier and which
// the patch owns. Containers of version 1 store such points as pairs.
struct StitchRepeat {
  uint32_t point = 0;
  uint32_t target = 0;
  bool operator==(const StitchRepeat&) const = default;
};

// Decoded point `point` of this patch is the point that `owner` owns as its number `rank`.
struct StitchPair {
  uint32_t point = 0;
  uint32_t owner = 0;
  uint32_t rank = 0;
  bool operator==(const StitchPair&) const = default;
};

// Runs ascend by `begin` and do not overlap; repeats and pairs ascend by `point`.
struct StitchMap {
  std::vector<StitchRun> runs;
  std::vector<StitchRepeat> repeats;
  std::vector<StitchPair> pairs;
};

// Writes the format of version 2. The patch owns the points of its repeats, and other patches own those of its
// pairs. `point_count` is the patch's number of decoded points.
std::vector<uint8_t> write_stitch_map(const StitchMap& map, uint32_t patch, uint32_t point_count);

// Checks every number against the directory. Errors are kInvalidInput, with the patch as their place.
Expected<StitchMap> parse_stitch_map(const PatchContainer& container, uint32_t patch);

}  // namespace psplit
