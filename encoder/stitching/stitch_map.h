// The stitch map: which points of a patch belong to another patch, and which points those are.
//
// Every point of the mesh has one owner, the lowest-numbered patch that uses it. A patch numbers the points it
// owns one after the other in the order of its decoded points; the rest of its decoded points are references.
// Nearly all references lie on the patch's border, where the neighbour walks the same border backwards, so
// most are stored as runs over both walks:
//
//        patch p  ... a  b  c  d ...   walk of p, forwards
//        -------------o--o--o--o----   the cut
//        patch q  ... a  b  c  d ...   walk of q, backwards
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "src/container/patch_container.h"
#include "src/parallel.h"

namespace psplit {

using Face = std::array<uint32_t, 3>;

// `length` consecutive points of this patch's walk, from `begin`, are the points of patch `owner`'s walk from
// `start`, counting down, or up where `forward` is set.
struct StitchRun {
  uint32_t begin = 0;
  uint32_t length = 0;
  uint32_t owner = 0;
  uint32_t start = 0;
  bool forward = false;
  bool operator==(const StitchRun&) const = default;
};

// Decoded point `point` of this patch is its decoded point `target` once more: that one comes earlier, and the
// patch owns it. In containers of version 1, such points are pairs.
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

// The border of a patch as points in walking order.
//
// A directed edge a -> b of a face is a border edge when no face of the patch has b -> a. Walks start at the
// lowest-numbered border point not yet walked and follow border edges until they close; the loops stand one
// after the other. A patch where a point has two border edges leaving it, or where a walk does not close, has
// no walk (empty): its references, and those to it, are pairs.
std::vector<uint32_t> border_walk(std::span<const Face> faces, uint32_t point_count);

// In the format of version 2. Nobody but the patch itself owns what repeats stand for, and another patch what
// pairs do. `point_count` is the patch's number of decoded points.
std::vector<uint8_t> write_stitch_map(const StitchMap& map, uint32_t patch, uint32_t point_count);

// Every number is checked against the directory; errors are kInvalidInput with the patch as their place.
Expected<StitchMap> parse_stitch_map(const PatchContainer& container, uint32_t patch);

// For each stream, the number in the whole mesh of each of its decoded points. `faces` holds each stream's
// decoded faces, whose points are below the entry's point_count.
Expected<std::vector<std::vector<uint32_t>>> number_points(const PatchContainer& container,
                                                           std::span<const std::span<const Face>> faces,
                                                           const ThreadPool& pool);

}  // namespace psplit
