// Condensing the patches that a document has already, without loss.
#pragma once

#include "gltf_ext/convert/encode_document_options.h"
#include "gltf_ext/convert/encode_reports.h"

namespace psplit {

// Condenses each container of version 2 in place whose primitive was left as it was, if that makes it smaller.
// Streams, numbering, accessors and everything else stay, and expand_document restores the streams. Updates the
// reports of these primitives. After an error the document is unusable.
Status condense_patches(Document& document, const EncodeDocumentOptions& options, const ThreadPool& pool,
                        EncodeReports& reports);

}  // namespace psplit
