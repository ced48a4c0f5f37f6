// Into how many patches primitives are cut.
#pragma once

#include <span>
#include <vector>

#include "gltf_ext/convert/encode_document_options.h"
#include "gltf_ext/convert/encode_job.h"

namespace psplit {

// 2, 4, 8, 16 or a multiple of 16 patches of about 30,000 faces, and one patch below `min_faces`. Threads then
// get equal work, and the bytes beyond those of a single stream are about 2 % (docs/benchmarks.md).
uint64_t default_patch_count(uint64_t faces, uint64_t min_faces = kMinFaces);

// The number of patches of each primitive, given its number of faces.
std::vector<uint32_t> patch_counts(std::span<const uint64_t> faces, const EncodeDocumentOptions& options);

// The same of jobs.
std::vector<uint32_t> patch_counts(std::span<const EncodeJob> jobs, const EncodeDocumentOptions& options);

}  // namespace psplit
