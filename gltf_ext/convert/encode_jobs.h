// Primitives on their way through the encoder: what is read of a document before it is encoded.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "gltf_ext/convert/convert.h"
#include "gltf_ext/primitive/primitive_edit.h"

namespace psplit {

// One geometry, and the primitives that have it.
struct Job {
  PrimitiveGroup group;
  Mesh mesh;
  std::vector<MorphAttribute> morphs;
  std::vector<Attribute> unrounded;  // skin weights as they came
  std::vector<AttributeCoding> codings;
  EncodeOptions options;
  EncodedMesh encoded;
  StoredAs stored_as = StoredAs::kAsItWas;
  uint64_t stored_bytes = 0;  // container or streams
  Status status;

  Place place(const Document& document) const {
    const PrimitiveId id = group.ids.front();
    return {document.source.string(), static_cast<int64_t>(id.mesh), static_cast<int64_t>(id.primitive), -1};
  }
};

struct Jobs {
  std::vector<Job> jobs;
  std::map<std::pair<size_t, size_t>, std::string> skipped;  // why, by mesh and primitive
};

// Reads every primitive that nothing speaks against, equal ones once, and says how its attributes are coded.
Expected<Jobs> read_jobs(const Document& document, const EncodeDocumentOptions& options,
                         const DecodeBackend& backend, const ThreadPool& pool);

void choose_patch_counts(std::vector<Job>& jobs, const EncodeDocumentOptions& options);

// What tells points apart that are equal otherwise: morph targets and weights before rounding, interleaved.
std::vector<std::byte> distinguishing_bytes(const Job& job, size_t& stride);

// Morph targets in the order of the stored points.
std::vector<MorphAttribute> reorder(const std::vector<MorphAttribute>& morphs,
                                    const std::vector<uint32_t>& source_point);

}  // namespace psplit
