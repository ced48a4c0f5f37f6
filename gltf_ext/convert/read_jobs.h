// The geometry of a document, read for the encoder.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "gltf_ext/convert/encode_job.h"
#include "gltf_ext/convert/select_primitives.h"
#include "psplit/gltf.h"

namespace psplit {

// Reads the primitives that are encoded in memory. Primitives that turn out to be empty are added to
// selected.skipped. Primitives that share points are divided (SharedPoints).
Expected<std::vector<EncodeJob>> read_jobs(const Document& document, const EncodeDocumentOptions& options,
                                           SelectedPrimitives& selected, const DecodeBackend& backend,
                                           const ThreadPool& pool);

// The attributes that EXT_structural_metadata reads: data of the application, which must not be rounded.
std::set<std::string> metadata_attributes(const Json& json);

// Plans all jobs (psplit/encode.h); jobs of a group share their grids. Warns in a job's `warnings` of what the
// grids cannot keep. Returns the groups.
Expected<GridGroups> plan_jobs(const Document& document, const EncodeDocumentOptions& options,
                               const SkippedPrimitives& skipped, std::vector<EncodeJob>& jobs,
                               const ThreadPool& pool);

// Selects, reads and plans: for callers with all of the document in memory.
struct PlannedJobs {
  std::vector<EncodeJob> jobs;
  SkippedPrimitives skipped;
};
Expected<PlannedJobs> read_and_plan(const Document& document, const EncodeDocumentOptions& options,
                                    const DecodeBackend& backend, const ThreadPool& pool);

}  // namespace psplit
