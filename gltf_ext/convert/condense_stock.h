// Condensing a stock Draco stream as it is, without encoding its mesh again.
#pragma once

#include "gltf_ext/convert/encode_job.h"

namespace psplit {

// If the job's primitive is stock Draco, and its stream takes fewer bytes as the only patch of a container of
// version 3, makes that container `job.encoded` and sets `job.keeps_stream`. Otherwise leaves the job: so do
// sequential streams, streams of old bitstreams, and streams whose types differ from their accessors'. Errors:
// kRuntimeFailure if the container does not decode, which is a bug.
Status condense_stock(const Document& document, EncodeJob& job);

}  // namespace psplit
