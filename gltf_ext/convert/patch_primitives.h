// Patches as primitives of their own, each one ordinary KHR_draco_mesh_compression: what any loader opens
// today.
#pragma once

#include <span>
#include <vector>

#include "encoder/encode_mesh.h"
#include "gltf_ext/primitive/primitive_edit.h"

namespace psplit {

// One stream of a container on its own.
struct PatchPrimitive {
  std::span<const uint8_t> stream;     // of the container
  Mesh mesh;                           // what it decodes to
  std::vector<uint32_t> source_point;  // for each decoded point, the point of the input
};

// The container's streams, decoded; where encode_mesh decoded the whole, each must be the part of it that its
// row says. `requests` are the mesh's attributes. Errors: those of the backend, and kRuntimeFailure for a
// difference.
Expected<std::vector<PatchPrimitive>> patch_primitives(const EncodedMesh& encoded,
                                                       std::span<const AttributeRequest> requests,
                                                       const DecodeBackend& backend, const ThreadPool& pool);

// Puts counts[i] copies of each primitive of groups[i] in its place, and returns for each group the groups of
// first copies, of second copies and so on. `groups` name primitives of the document as it was before.
std::vector<std::vector<PrimitiveGroup>> repeat_primitives(Document& document,
                                                           std::span<const PrimitiveGroup> groups,
                                                           std::span<const size_t> counts);

}  // namespace psplit
