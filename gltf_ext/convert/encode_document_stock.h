// A plain glTF document to stock KHR_draco_mesh_compression, as the baseline that patches are compared with.
#pragma once

#include <vector>

#include "gltf_ext/convert/encode_document_options.h"
#include "gltf_ext/convert/primitive_report.h"
#include "gltf_ext/convert/stated_grids.h"
#include "gltf_ext/document/document.h"
#include "src/parallel.h"

namespace psplit {

// Stores every plain triangle primitive as one stream of KHR_draco_mesh_compression, in place. The reports'
// statistics count what a stream cannot hold: faces that repeat a point, and points that no other face uses.
// Values that are on a grid of `stated`, which their streams stated before they were decoded, keep it.
Expected<std::vector<PrimitiveReport>> encode_document_stock(Document& document,
                                                             const EncodeDocumentOptions& options,
                                                             const ThreadPool& pool,
                                                             const StatedGrids& stated = {});

}  // namespace psplit
