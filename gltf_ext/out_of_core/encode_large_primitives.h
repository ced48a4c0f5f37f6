// Encodes a glTF asset whose primitives may be larger than memory.
#pragma once

#include <string>
#include <vector>

#include "gltf_ext/convert/encode_document.h"
#include "gltf_ext/out_of_core/out_of_core_options.h"

namespace psplit {

// Encodes the primitives that do not fit into memory part by part (see encode_out_of_core), and then the others
// by encode_document. The buffers should be mapped (FileAccess::kMap). If a primitive becomes several, those
// after it in its mesh get higher numbers, also in the reports. After an error the document is unusable.
// Errors: those of encode_document, encode_spool and stream_primitive; kUnsupported if a primitive that does
// not fit would share its grid with others.
Expected<std::vector<PrimitiveReport>> encode_large_primitives(
    Document& document, const EncodeDocumentOptions& options, const OutOfCoreOptions& limits,
    const DecodeBackend& backend, const ThreadPool& pool, const Progress& progress = {});

}  // namespace psplit
