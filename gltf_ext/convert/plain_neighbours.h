// Primitives that stay as they are beside quantized ones, whose positions have moved to a grid.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "gltf_ext/convert/encode_job.h"
#include "psplit/encode.h"

namespace psplit {

// The grid of positions of each group of primitives that share grids (GridGroups).
std::map<size_t, AttributeCoding> position_grids(std::span<EncodeJob> jobs, const GridGroups& groups);

// Rounds the positions of primitives that stay plain to the grid of their group, so that surfaces that touched
// still touch. Values are replaced in place; if other objects use them as well, the new values are stored
// elsewhere. Positions that are compressed, or not floats, stay: a warning says so if boxes of both meet.
// `origins` has, for each primitive of `output`, the primitive of the input from which it comes.
Status round_plain_neighbours(Document& output, std::span<const PrimitiveId> origins,
                              std::span<const EncodeJob> jobs, const GridGroups& groups,
                              const std::map<size_t, AttributeCoding>& grids, const ThreadPool& pool,
                              EncodeReports& reports);

}  // namespace psplit
