// The stitch map: which points of a patch belong to another patch, and which points those are.
//
// Every point of the mesh has one owner: the lowest-numbered patch that uses it. A patch numbers the points
// that it owns consecutively, in the order of its decoded points. Its other decoded points are references.
// Nearly all of them are on the patch's border, where the neighbour walks the same border backwards. So most
// references are stored as runs over both walks (border_walk):
//
//        patch p  ... a  b  c  d ...   walk of p, forwards
//        -------------o--o--o--o----   the cut
//        patch q  ... a  b  c  d ...   walk of q, backwards
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "psplit/parallel.h"
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
// the patch owns.
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

// The patch owns the points of its repeats, and other patches own the points of its pairs. `point_count` is the
// patch's number of decoded points.
std::vector<uint8_t> write_stitch_map(const StitchMap& map, uint32_t patch, uint32_t point_count);

// Checks every number against the directory. Errors are kInvalidInput, with the patch as their place.
Expected<StitchMap> parse_stitch_map(const PatchContainer& container, uint32_t patch);

using Face = std::array<uint32_t, 3>;

// A directed edge a -> b of a face is a border edge if no face of the patch has b -> a. Walks start at the
// lowest-numbered border point that is not walked yet, and follow border edges until they close. The loops
// follow each other in the result. A patch has no walk (empty) if two border edges leave one of its points, or
// if a walk does not close. Its references, and those to it, are then stored as pairs.
std::vector<uint32_t> border_walk(std::span<const Face> faces, uint32_t point_count);

// For each stream, the number in the whole mesh of each of its decoded points, by the definition of the stitch
// map: for libdraco's backend, and for tests of the core's stitching. `faces` holds each stream's decoded
// faces, whose points are below the entry's point_count. Errors are kInvalidInput, with the patch as their
// place.
Expected<std::vector<std::vector<uint32_t>>> number_points(const PatchContainer& container,
                                                           std::span<const std::span<const Face>> faces,
                                                           const ThreadPool& pool);

}  // namespace psplit
