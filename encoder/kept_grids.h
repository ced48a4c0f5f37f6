// Grids that values are on already. They are kept, so that encoding the output of an encoder changes nothing.
#pragma once

#include <set>
#include <span>
#include <string>
#include <vector>

#include "encoder/shared_codings.h"

namespace psplit {

// Gives attributes whose values are all on their stated grid (MeshToEncode) this grid, unless other bits are
// given for them. In a group that shares a grid, meshes beside them get it, too, if it holds their values; if
// it does not, or if there are several such grids, none of them is kept. `bounds` are those by which `codings`
// were chosen, for the points in `stored`. Returns for each coding whether it is final: it has such a grid.
std::vector<std::vector<bool>> keep_grids(std::span<MeshToEncode* const> meshes, std::span<const KeptMesh> kept,
                                          const EncodeOptions& options,
                                          std::span<const std::vector<CodingBounds>> bounds,
                                          std::span<const StoredFlags> stored,
                                          std::span<std::vector<AttributeCoding>> codings,
                                          const ThreadPool& pool);

}  // namespace psplit
