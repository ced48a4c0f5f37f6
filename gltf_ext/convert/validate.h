// Every rule of PSPLIT_mesh_draco_patches, checked against a whole document.
#pragma once

#include <string>
#include <vector>

#include "gltf_ext/primitive/read_primitives.h"

namespace psplit {

struct Finding {
  std::string rule;  // stable: see the table in validate.cpp
  std::string message;
  Place place;
  bool error = true;                            // otherwise a warning
  StatusCode code = StatusCode::kInvalidInput;  // or kUnsupported: what is beyond this decoder may be right
};

// Decodes every patch and checks every reference. Empty when nothing is wrong.
std::vector<Finding> validate_document(const Document& document, const DecodeBackend& backend,
                                       const ThreadPool& pool);

// Whether a primitive without patches, and its morph targets, can be read. kUnsupported for lines and points.
Status check_readable(const Document& document, PrimitiveId id, const DecodeBackend& backend,
                      const ThreadPool& pool);

// What decoding refuses beside what cannot be decoded: the first error of the rules, all but "attribute-type"
// and "copies", which take every stream once more. `meshes` are what the primitives `ids`, in patches, decode
// to.
Status check_decoded(const Document& document, std::span<const PrimitiveId> ids,
                     std::span<const Mesh* const> meshes, const DecodeBackend& backend, const ThreadPool& pool);

// The same of all primitives in patches, decoded for it: for commands that pass them on as they are.
Status check_patches(const Document& document, const DecodeBackend& backend, const ThreadPool& pool);

}  // namespace psplit
