// EXT_meshopt_compression and KHR_meshopt_compression, on reading: buffer views become plain.
#pragma once

#include "gltf_ext/document/document.h"

namespace psplit {

// Whether a buffer only stands in for what meshoptimizer decodes: it may come without bytes.
bool is_meshopt_fallback(const Json& buffer);

// Decodes every compressed buffer view, filters included, into one new buffer, takes the extensions from them
// and sweeps out the compressed bytes and the fallback buffers. Views of a bitstream that is newer than the
// meshoptimizer at hand stay as they are. The document has passed check_structure and has its buffers. What is
// decoded is at most 64 times what is compressed, which is as far as the codec goes. Errors: kInvalidInput.
Status decode_meshopt_views(Document& document);

}  // namespace psplit
