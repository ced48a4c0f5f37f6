// The result of encoding a document, for each primitive.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "encoder/encoded_mesh.h"
#include "gltf_ext/document/document.h"
#include "src/container/stream_entry.h"

namespace psplit {

// How the output stores a primitive.
enum class StoredAs {
  kAsItWas,
  kPatches,         // PSPLIT_mesh_draco_patches
  kDraco,           // KHR_draco_mesh_compression, one stream
  kPatchPrimitives  // several primitives in KHR_draco_mesh_compression
};

// Why primitives are left as they are, by mesh and primitive.
using SkippedPrimitives = std::map<std::pair<size_t, size_t>, std::string>;

struct PrimitiveReport {
  PrimitiveId id;       // in the input: with Compat::kKhr a primitive becomes several
  std::string skipped;  // why it was left as it is ("points or lines", "already in patches"), or empty
  std::vector<std::string> notes;               // what was done for its precision, and what that costs
  std::vector<std::string> warnings;            // what it lost
  std::vector<std::string> dropped_attributes;  // those of EncodeDocumentOptions::skip that it had
  StoredAs stored_as = StoredAs::kAsItWas;
  // An earlier primitive has the same geometry, which is stored once: sums leave this primitive's bytes out.
  bool repeated = false;
  // The streams are those of the input, condensed without loss.
  bool keeps_streams = false;
  uint64_t faces = 0, points = 0;  // of the input; 0 if it was not read
  uint64_t input_bytes = 0;  // of its attributes and indices as the input stores them, without morph targets
  // Those of the output's container or streams, without a fallback; input_bytes for kAsItWas.
  uint64_t bytes = 0;
  std::vector<StreamEntry> streams;  // the container's directory
  bool has_residue = false;
  uint64_t head_bytes = 0;          // of its container
  AttributeCoding position_coding;  // 0 bits: positions are stored exactly, or by the input's encoder
  EncodeStatistics statistics;
};

}  // namespace psplit
