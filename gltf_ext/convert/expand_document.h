// Condensed patches to patches that every loader of the extension decodes.
#pragma once

#include "gltf_ext/document/document.h"
#include "src/container/decode_backend.h"
#include "src/export.h"
#include "src/parallel.h"

namespace psplit {

struct ExpandReport {
  size_t primitives = 0;                       // all of the document
  size_t to_patches = 0;                       // those whose container has Draco streams now
  size_t to_draco = 0;                         // those that are KHR_draco_mesh_compression now
  uint64_t bytes_before = 0, bytes_after = 0;  // of these primitives' containers and streams; shared ones once
};

// Expands every container of condensed streams in place. A container of one patch without residue becomes the
// stream of KHR_draco_mesh_compression that its patch is. If its stitch map joins points, these are apart then,
// so it needs a primitive without a fallback, morph targets or other attributes. All others become containers
// of Draco streams. Streams are those that libdraco's encoder wrote, bit for bit. Nothing else in the document
// changes, except the lists of used extensions: it is what the encoder would have made without condensing. All
// primitives are decoded once, by `backend`, and what is written by the CPU: what decode_document refuses is
// refused here. After an error the document is unusable.
PSPLIT_EXPORT Expected<ExpandReport> expand_document(Document& document, const DecodeBackend& backend,
                                                     const ThreadPool& pool);

}  // namespace psplit
