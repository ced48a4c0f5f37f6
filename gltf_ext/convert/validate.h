// Every rule of PSPLIT_mesh_draco_patches, checked against a whole document.
#pragma once

#include <span>
#include <vector>

#include "gltf_ext/convert/finding.h"
#include "gltf_ext/primitive/memory_limit.h"
#include "gltf_ext/primitive/mesh_view.h"
#include "gltf_ext/primitive/read_primitives.h"

namespace psplit {

// Decodes every patch once and checks every rule, primitives in parallel. Returns the findings in the order of
// the primitives; empty if the document is valid. Primitives in patches that are too large for `limit` are
// checked one after the other (primitive_rules.h).
std::vector<Finding> validate_document(const Document& document, const DecodeBackend& backend,
                                       const ThreadPool& pool, const MemoryLimit& limit = {});

// Whether a primitive without patches, and its morph targets, can be read. kUnsupported for lines and points.
Status check_readable(const Document& document, PrimitiveId id, const DecodeBackend& backend,
                      const ThreadPool& pool);

// The first error of all rules, except those that need each stream ("attribute-type" and "copies"). meshes[i]
// is the decoded mesh of primitive ids[i], which is in patches: so a caller that reads the meshes checks them
// without decoding them again.
Status check_decoded(const Document& document, std::span<const PrimitiveId> ids,
                     std::span<const MeshView> meshes);

// Decodes all primitives in patches, and checks them with check_decoded: for commands that pass them on
// unchanged. The meshes are not kept.
Status check_patches(const Document& document, const DecodeBackend& backend, const ThreadPool& pool);

}  // namespace psplit
