// EncodeDocumentOptions::meshopt: what stays in buffer views after encoding, compressed by meshoptimizer.
#pragma once

#include "gltf_ext/document/document.h"
#include "psplit/gltf.h"
#include "psplit/parallel.h"

namespace psplit {

// kUsage if the options are out of their ranges, with limits of memory, and in a build without meshoptimizer.
Status check_rest(const EncodeDocumentOptions& options, const OutOfCoreOptions& limits);

// Moves values of accessors that are neither Draco's nor a fallback's into few buffer views, and compresses
// these. A view that would not become smaller stays as it is, and so does the document.
Status compress_rest(Document& document, const EncodeDocumentOptions& options, const ThreadPool& pool);

}  // namespace psplit
