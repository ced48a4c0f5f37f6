// EXT_meshopt_compression and KHR_meshopt_compression are decoded on reading: buffer views become plain.
#pragma once

#include "gltf_ext/document/document.h"

namespace psplit {

// Decodes every compressed buffer view, filters included, into one new buffer. Removes the extensions from the
// views, and drops the compressed bytes and the fallback buffers. Views whose bitstream is newer than the
// linked meshoptimizer stay as they are. The document must have passed check_structure, with its buffers
// loaded. Decoded data is at most 64 times as large as compressed data, which is the most that the codec
// reaches. Errors: kInvalidInput.
Status decode_meshopt_views(Document& document);

}  // namespace psplit
