// The geometry of a document, read for the encoder.
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "gltf_ext/convert/encode_document_options.h"
#include "gltf_ext/convert/encode_job.h"
#include "gltf_ext/convert/primitive_report.h"
#include "gltf_ext/convert/stated_grids.h"

namespace psplit {

// The attributes that EXT_structural_metadata reads: data of the application, which must not be rounded.
std::set<std::string> metadata_attributes(const Json& json);

// The name of an extension of the primitive whose data follow the order of points or faces; null if it has
// none.
const char* order_dependent_extension(const Json& primitive);

inline constexpr const char* kOnlyDegenerate = "no triangles but degenerate ones";

struct EncodeJobs {
  std::vector<EncodeJob> jobs;  // those that are encoded already, in parts, are the last
  SkippedPrimitives skipped;
  GridGroups groups;
};

// Reads every primitive that can be encoded, equal ones once, and chooses how its attributes are coded. With
// limits.memory, the largest primitives are encoded part by part before, so that all others fit together.
// `progress` counts the faces of these. `forget` is called when the values of one of them are not read any
// more. `stated` are grids of primitives that were decoded before.
Expected<EncodeJobs> read_jobs(const Document& document, const EncodeDocumentOptions& options,
                               const DecodeBackend& backend, const ThreadPool& pool,
                               const OutOfCoreOptions& limits = {}, const Progress& progress = {},
                               const std::function<void()>& forget = {}, const StatedGrids& stated = {});

}  // namespace psplit
