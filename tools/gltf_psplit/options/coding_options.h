// The options of `encode`, `batch`, `compare` and `decode --to draco` for precision, speed and the cut into
// patches.
#pragma once

#include "gltf_ext/convert/encode_document_options.h"

namespace CLI {
class App;
}

namespace psplit {

// Each adds options that write to `options`, which must outlive the parse.
void add_coding_options(CLI::App& command, EncodeDocumentOptions& options);     // precision, Draco's speed
void add_partition_options(CLI::App& command, EncodeDocumentOptions& options);  // --distance, --no-refine

}  // namespace psplit
