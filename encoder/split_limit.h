// A bound of what it costs to cut a mesh into patches.
//
// Patches take more bytes than one stream: points at borders are in several, each stream has tables of its own,
// and a container needs a stitch map. Of most meshes that is 1 or 2 %, and the patches alone tell it. Of
// others, such as thousands of boxes that touch, it is more than all the rest.
#pragma once

#include <cstdint>
#include <span>

#include "encoder/encode_streams.h"

namespace psplit {

// encode_streams with `patch_count` patches, or with fewer as options.most_split_percent says. One stream
// is encoded, too, only if the patches do not show that they keep the limit.
Expected<Streams> encode_within_limit(const Mesh& mesh, std::span<const AttributeCoding> codings,
                                      const StreamOptions& options, uint32_t patch_count,
                                      const ThreadPool& pool, EncodeStatistics& statistics);

}  // namespace psplit
