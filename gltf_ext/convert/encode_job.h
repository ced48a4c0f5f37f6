// One geometry on its way through the encoder.
#pragma once

#include <string>
#include <vector>

#include "encoder/encode_mesh.h"
#include "gltf_ext/convert/primitive_report.h"
#include "gltf_ext/primitive/primitive_edit.h"

namespace psplit {

struct EncodeJob {
  PrimitiveGroup group;  // the primitives that have this geometry
  Mesh mesh;
  std::vector<MorphAttribute> morphs;
  std::vector<Attribute> unrounded;  // the skin weights of the input
  std::vector<AttributeCoding> codings;
  EncodeOptions options;
  EncodedMesh encoded;
  StoredAs stored_as = StoredAs::kAsItWas;
  uint64_t stored_bytes = 0;  // of the container or the streams
  Status status;

  Place place(const Document& document) const {
    const PrimitiveId id = group.ids.front();
    return {document.source.string(), static_cast<int64_t>(id.mesh), static_cast<int64_t>(id.primitive), -1};
  }
};

// Data that keeps points apart whose attributes are equal: morph targets, and weights before rounding. Returns
// `stride` bytes for each point.
std::vector<std::byte> distinguishing_bytes(const EncodeJob& job, size_t& stride);

// Morph targets in the order of the stored points: point i is source_point[i] of the input.
std::vector<MorphAttribute> reorder(const std::vector<MorphAttribute>& morphs,
                                    const std::vector<uint32_t>& source_point);

}  // namespace psplit
