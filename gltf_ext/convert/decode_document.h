// A compressed document to plain glTF.
#pragma once

#include "gltf_ext/document/document.h"
#include "src/container/decode_backend.h"
#include "src/export.h"

namespace psplit {

// Decodes every primitive in patches and every primitive in stock Draco into plain accessors, in place.
PSPLIT_EXPORT Status decode_document(Document& document, const DecodeBackend& backend, const ThreadPool& pool,
                                     const Progress& progress = {});

}  // namespace psplit
