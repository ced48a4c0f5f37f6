// Every rule of PSPLIT_mesh_draco_patches, checked against a whole document.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "gltf_ext/primitive/mesh_view.h"
#include "gltf_ext/primitive/read_primitives.h"
#include "psplit/base.h"
#include "psplit/document.h"
#include "src/cpu/checked_decode.h"

namespace psplit {

// A broken rule of PSPLIT_mesh_draco_patches.
struct Finding {
  std::string rule;  // stable: see the table in validate.cpp
  std::string message;
  Place place;
  bool error = true;  // otherwise a warning
  // Or kUnsupported: this decoder cannot tell whether it is valid. All other codes are of failures that say
  // nothing about the asset, such as a full disk.
  StatusCode code = StatusCode::kInvalidInput;
  // Whether only the validator checks this rule: decode_document corrects its violations, or does not depend on
  // it.
  bool only_validated = false;

  bool is_refused() const { return error && !only_validated; }
};

// The first failure that kept a check from its end; ok if there is none.
inline Status first_failure(std::span<const Finding> findings) {
  for (const Finding& finding : findings)
    if (finding.error && finding.code != StatusCode::kInvalidInput && finding.code != StatusCode::kUnsupported)
      return {finding.code, finding.message, finding.place};
  return {};
}

// Decodes every patch once and checks every rule, primitives in parallel. Returns the findings in the order of
// the primitives; empty if the document is valid. Primitives in patches that are too large for `limit` are
// checked one after the other (check_patched_primitive).
std::vector<Finding> validate_document(const Document& document, const DecodeBackend& backend,
                                       const ThreadPool& pool, const MemoryLimit& limit = {});

// Whether a primitive without patches, and its morph targets, can be read. kUnsupported for lines and points.
Status check_readable(const Document& document, PrimitiveId id, const DecodeBackend& backend,
                      const ThreadPool& pool);

// The first error for which decode_document, encode_document and expand_document refuse a document: for callers
// that do not need its meshes. Decodes every primitive once.
Status check_document(const Document& document, const DecodeBackend& backend, const ThreadPool& pool,
                      const MemoryLimit& limit = {});

// Checks only the primitives in patches.
Status check_patches(const Document& document, const ThreadPool& pool);

// Checks a document whose meshes the caller has decoded: meshes[i] belongs to primitive ids[i], which is in
// patches, and streams[i] has the findings of its streams; empty if there are none. `backend` decodes coarse
// primitives.
Status check_decoded(const Document& document, std::span<const PrimitiveId> ids,
                     std::span<const MeshView> meshes, std::span<const std::vector<StreamFindings>> streams,
                     const DecodeBackend& backend, const ThreadPool& pool);

// Whether values of meshes are checked as well (check_values.h), and what stock Draco's accessors state.
enum class ValueWarnings { kNone, kAll };

// Checks a primitive in patches by every rule. Each stream is decoded once, by the CPU's decoder. If `backend`
// is another one, it decodes the container too, and the rules for decoded data are checked on its mesh. If the
// mesh is too large for `limit`, only the CPU decodes it, into a temporary file.
std::vector<Finding> check_patched_primitive(const Document& document, PrimitiveId id,
                                             const DecodeBackend& backend, const ThreadPool& pool,
                                             const MemoryLimit& limit = {},
                                             ValueWarnings warnings = ValueWarnings::kAll);

// Whether check_patched_primitive would put the mesh into a temporary file, if its JSON is right.
bool is_too_large_to_check(const Document& document, PrimitiveId id, const MemoryLimit& limit);

// Checks a primitive in patches by all rules except "boxes". `mesh` is its decoded mesh, and may have more
// attributes than the patches.
std::vector<Finding> check_decoded_primitive(const Document& document, PrimitiveId id, const MeshView& mesh,
                                             std::span<const StreamFindings> streams = {});

}  // namespace psplit
