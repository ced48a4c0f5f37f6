// Streams of a document to condensed ones, without loss: the way that expand_document takes back.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "gltf_ext/document/document.h"
#include "psplit/decode.h"
#include "psplit/parallel.h"

namespace psplit {

struct CondenseOptions {
  bool smallest = false;  // also if that decodes more slowly
  bool verify = true;     // compare what each container decodes to with what its streams decode to
  // What the container of a primitive decodes to, by its semantics, if that is known: then it is not decoded
  // again. Null if not. Called by several threads.
  std::function<const Mesh*(PrimitiveId)> decoded = [](PrimitiveId) { return nullptr; };
};

// What became of the streams in one buffer view.
struct CondensedView {
  std::vector<PrimitiveId> ids;      // the primitives that have them
  bool was_condensed = false;        // it stays
  uint64_t bytes = 0;                // of the condensed container; 0 if the streams stay
  std::vector<StreamEntry> entries;  // its directory
  bool has_residue = false;
  uint32_t face_count = 0, point_count = 0, head_bytes = 0;
  double condense_ms = 0, verify_ms = 0;
};

// Condenses the containers and the stock Draco streams of the primitives `ids`, in place. A stream of stock
// Draco becomes a container of one patch. All decoded data stay unchanged, and so does the rest of the
// document, except the lists of used extensions, and accessor bounds that differ from the decoded values'
// bounds. expand_document restores the streams.
//
// Nothing is condensed that would make the file larger. The comparison counts all bytes of the file: the bytes
// with their padding, and the JSON of extensions and accessors, on one line (GLB) and indented (.gltf).
// Sequential streams, and primitives that PSPLIT_mesh_draco_patches excludes, stay. Errors: kInvalidInput for a
// broken container; kRuntimeFailure if a condensed container does not decode to the same mesh, which is a bug.
Expected<std::vector<CondensedView>> condense_document(Document& document, std::span<const PrimitiveId> ids,
                                                       const CondenseOptions& options, const ThreadPool& pool);

}  // namespace psplit
