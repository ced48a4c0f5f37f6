// A compressed document to plain glTF.
#pragma once

#include "gltf_ext/document/document.h"
#include "gltf_ext/primitive/memory_limit.h"
#include "src/container/decode_backend.h"
#include "src/export.h"

namespace psplit {

// Decodes every primitive in patches and every primitive in stock Draco into plain accessors, in place. If they
// are too large for `limit`, the CPU decodes all primitives in patches, window by window, into a temporary
// file, which becomes a buffer of the document; the file that write_document makes is the same. Primitives in
// stock Draco are decoded one after the other, each of them in memory. Coarse primitives are dropped. Views that
// meshoptimizer compressed become plain, too.
// An exception: a buffer that ends with other data, at an odd multiple of 4, is followed by 8 bytes more. After
// an error the document may be of no use.
PSPLIT_EXPORT Status decode_document(Document& document, const DecodeBackend& backend, const ThreadPool& pool,
                                     const Progress& progress = {}, const MemoryLimit& limit = {});

}  // namespace psplit
