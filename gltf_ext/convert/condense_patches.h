// Condensing the streams that a document has already, without loss.
#pragma once

#include "gltf_ext/convert/encode_document_options.h"
#include "gltf_ext/convert/encode_job.h"
#include "gltf_ext/convert/encode_reports.h"

namespace psplit {

// By buffer view.
using CondensedPatches = std::map<int64_t, std::vector<uint8_t>>;

// Condenses each container of Draco streams whose primitive is left as it is, if that makes it smaller.
// Streams, numbering, accessors and everything else stay, and expand_document restores the streams. Updates the
// reports of these primitives. `document` is the input.
Expected<CondensedPatches> condense_patches(const Document& document, const EncodeDocumentOptions& options,
                                            const ThreadPool& pool, EncodeReports& reports);

// If the job's primitive is stock Draco, and its stream takes fewer bytes as the only patch of a container,
// makes that container `job.encoded` and sets `job.keeps_stream`. Otherwise leaves the job: so do
// sequential streams, streams of old bitstreams, and streams whose types differ from their accessors'. Errors:
// kRuntimeFailure if the container does not decode, which is a bug.
Status condense_stock(const Document& document, EncodeJob& job);

}  // namespace psplit
