// Points that stock Draco repeats where a surface is not manifold, joined by the stitch map of a patch.
#pragma once

#include "gltf_ext/convert/encode_job.h"

namespace psplit {

// Makes the lone stream of a job the patch of a condensed container that joins its repeated points. Leaves the
// job if no point is repeated, if the file might not get smaller, or if condensing the stream alone saves as
// much. Errors: kRuntimeFailure if the container does not decode to the same triangles, which is a bug.
Status join_repeated_points(EncodeJob& job, const EncodeDocumentOptions& options, const ThreadPool& pool);

}  // namespace psplit
