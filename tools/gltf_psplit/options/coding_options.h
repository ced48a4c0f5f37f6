// The options of `encode`, `batch`, `compare` and `decode --to draco` for precision, speed and the cut into
// patches.
#pragma once

#include "gltf_ext/convert/encode_document_options.h"

namespace CLI {
class App;
}

namespace psplit {

// Each adds options that write to `options`, which must outlive the parse.
// Precision, Draco's speed. With `fits_mesh`, the command can also choose the bits of positions for each mesh:
// --quantize-position auto, and --max-error.
void add_coding_options(CLI::App& command, EncodeDocumentOptions& options, bool fits_mesh);
void add_partition_options(CLI::App& command, EncodeDocumentOptions& options);  // --distance, --no-refine

}  // namespace psplit
