// A bound of what it costs to cut a mesh into patches.
//
// Patches take more bytes than one stream: points at borders are in several, each stream has tables of its own,
// and a container needs a stitch map. Of most meshes that is 1 or 2 %, and the patches alone tell it. Of
// others, such as thousands of boxes that touch, it is more than all the rest.
#pragma once

#include <cstdint>

#include "encoder/encode_streams.h"
#include "psplit/parallel.h"

namespace psplit {

// Whether the streams may take more than options.most_split_percent beyond those of one stream. Of the corpus'
// meshes this finds all that do. The smallest coding is less even: what one stream takes of it is known only
// once it is there.
bool may_exceed_limit(const Mesh& mesh, const Streams& streams, const StreamOptions& options);

// The bytes of the streams as they are stored, less the tables that will be shared.
uint64_t stored_bytes(const Mesh& mesh, const Streams& streams, const StreamOptions& options,
                      const ThreadPool& pool);

}  // namespace psplit
