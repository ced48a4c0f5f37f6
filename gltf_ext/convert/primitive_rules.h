// The rules of PSPLIT_mesh_draco_patches for one primitive.
#pragma once

#include <vector>

#include "gltf_ext/convert/finding.h"
#include "gltf_ext/primitive/memory_limit.h"
#include "gltf_ext/primitive/mesh_view.h"
#include "gltf_ext/primitive/read_primitives.h"

namespace psplit {

// Checks a primitive in patches by every rule. Each stream is decoded once, by the CPU's decoder. If `backend`
// is another one, it decodes the container too, and the rules for decoded data are checked on its mesh. If the
// mesh is too large for `limit`, only the CPU decodes it, into a temporary file.
std::vector<Finding> check_patched_primitive(const Document& document, PrimitiveId id,
                                             const DecodeBackend& backend, const ThreadPool& pool,
                                             const MemoryLimit& limit = {});

// Whether check_patched_primitive would put the mesh into a temporary file, if its JSON is right.
bool is_too_large_to_check(const Document& document, PrimitiveId id, const MemoryLimit& limit);

// Checks a primitive in patches by all rules except those that need each stream: "attribute-type" and "copies".
// `mesh` is its decoded mesh, and may have more attributes than the patches.
std::vector<Finding> check_decoded_primitive(const Document& document, PrimitiveId id, const MeshView& mesh);

}  // namespace psplit
