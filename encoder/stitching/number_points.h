// The numbers of all decoded points in the whole mesh, by the definition of the stitch map: the oracle of the
// core's stitching, which works on lanes.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "encoder/stitching/border_walk.h"
#include "src/container/patch_container.h"
#include "src/parallel.h"

namespace psplit {

// For each stream, the number in the whole mesh of each of its decoded points. `faces` holds each stream's
// decoded faces, whose points are below the entry's point_count. Errors are kInvalidInput, with the patch as
// their place.
Expected<std::vector<std::vector<uint32_t>>> number_points(const PatchContainer& container,
                                                           std::span<const std::span<const Face>> faces,
                                                           const ThreadPool& pool);

}  // namespace psplit
