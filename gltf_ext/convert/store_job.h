// An encoded geometry becomes a part of its document.
#pragma once

#include <span>
#include <vector>

#include "gltf_ext/convert/encode_job.h"

namespace psplit {

// Makes the primitives of groups[k] refer to the piece k of the job, which has piece_count() of them, with the
// decoded mesh if there is a fallback. The bytes of a job in parts become mapped temporary files.
Status store_job(Document& document, EncodeJob& job, std::span<const PrimitiveGroup> groups,
                 const EncodeDocumentOptions& options, const OutOfCoreOptions& limits, const ThreadPool& pool,
                 PrimitiveEditor& editor);

// Lists the extensions of jobs that were stored: groups[i] belongs to jobs[i]. Call once, because it reads the
// whole JSON: the extension is required if a primitive has no fallback.
void list_stored(Document& document, std::span<const EncodeJob> jobs,
                 std::span<const std::vector<PrimitiveGroup>> groups);

}  // namespace psplit
