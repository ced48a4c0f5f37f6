// A compressed document to plain glTF.
#pragma once

#include "gltf_ext/document/document.h"
#include "gltf_ext/primitive/memory_limit.h"
#include "src/container/decode_backend.h"
#include "src/export.h"

namespace psplit {

struct Finding;

// Decodes every primitive in patches and every primitive in stock Draco into plain accessors, in place. If they
// are too large for `limit`, the CPU decodes all primitives in patches, window by window, into a temporary
// file, which becomes a buffer of the document; the file that write_document makes is the same. Primitives in
// stock Draco are decoded one after the other, each of them in memory. Coarse primitives are dropped. Views
// that meshoptimizer compressed become plain, too. An exception: a buffer that ends with other data, at an odd
// multiple of 4, is followed by 8 bytes more. After an error the document may be of no use. Primitives in
// patches are decoded by the CPU, which also compares copies of points, unless `backend` is CUDA's or
// libdraco's. `corrections`, if it is not null, gets the counts of accessors of stock Draco that its streams
// contradict: the document has those of the streams.
PSPLIT_EXPORT Status decode_document(Document& document, const DecodeBackend& backend, const ThreadPool& pool,
                                     const Progress& progress = {}, const MemoryLimit& limit = {},
                                     std::vector<Finding>* corrections = nullptr);

}  // namespace psplit
