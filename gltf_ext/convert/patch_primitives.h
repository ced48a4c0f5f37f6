// Each patch as a primitive of its own, in ordinary KHR_draco_mesh_compression, which existing loaders support.
#pragma once

#include <span>
#include <vector>

#include "encoder/encode_mesh.h"
#include "gltf_ext/primitive/primitive_edit.h"

namespace psplit {

// One stream of a container.
struct PatchPrimitive {
  std::span<const uint8_t> stream;     // of the container
  Mesh mesh;                           // the decoded stream
  std::vector<uint32_t> source_point;  // for each decoded point, the point of the input
};

// Decodes the container's streams. If encode_mesh decoded the whole, each stream must equal its part of it.
// Errors: those of the backend, and kRuntimeFailure for a difference.
Expected<std::vector<PatchPrimitive>> patch_primitives(const EncodedMesh& encoded, const DecodeBackend& backend,
                                                       const ThreadPool& pool);

// Replaces each primitive of groups[i] by counts[i] copies. Returns for each group the group of the first
// copies, of the second copies, and so on. `groups` refers to the primitives of the unchanged document.
std::vector<std::vector<PrimitiveGroup>> repeat_primitives(Document& document,
                                                           std::span<const PrimitiveGroup> groups,
                                                           std::span<const size_t> counts);

}  // namespace psplit
