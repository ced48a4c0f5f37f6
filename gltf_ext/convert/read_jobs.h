// The geometry of a document, read for the encoder.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "gltf_ext/convert/encode_document_options.h"
#include "gltf_ext/convert/encode_job.h"
#include "gltf_ext/convert/encode_spool.h"
#include "gltf_ext/convert/primitive_report.h"

namespace psplit {

// The attributes that EXT_structural_metadata reads: data of the application, which must not be rounded.
std::set<std::string> metadata_attributes(const Json& json);

// The reason why a primitive stays as it is; empty if it is encoded.
Expected<std::string> reason_to_skip(const Document& document, PrimitiveId id,
                                     const EncodeDocumentOptions& options);

inline constexpr const char* kOnlyDegenerate = "no triangles but degenerate ones";

// A geometry that does not fit into memory.
struct LargeJob {
  PrimitiveGroup group;
  EncodedSpool encoded;
};

struct EncodeJobs {
  std::vector<EncodeJob> jobs;
  std::vector<LargeJob> large;
  SkippedPrimitives skipped;
};

// Reads every primitive that can be encoded, equal ones once, and chooses how its attributes are coded. With
// limits.memory, the largest primitives are encoded part by part before, so that all others fit together.
// `progress` counts the faces of these.
Expected<EncodeJobs> read_jobs(const Document& document, const EncodeDocumentOptions& options,
                               const DecodeBackend& backend, const ThreadPool& pool,
                               const OutOfCoreOptions& limits = {}, const Progress& progress = {});

}  // namespace psplit
