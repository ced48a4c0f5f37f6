// Encodes a mesh part by part.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "gltf_ext/convert/encode_job.h"
#include "gltf_ext/convert/select_primitives.h"
#include "gltf_ext/out_of_core/large_mesh.h"
#include "gltf_ext/out_of_core/mesh_spool.h"
#include "psplit/gltf.h"

namespace psplit {

// How a mesh file is read (read_spool) that encode_document gets with these options.
SpoolOptions spool_options(const EncodeDocumentOptions& options, const OutOfCoreOptions& limits);

// Encodes the large primitives, one after the other. The bytes of their jobs are in temporary files. Primitives
// without anything to encode are added to selected.skipped. `forget` is called when the values of a primitive
// are no longer read; `progress` counts faces. Errors: as CellParts and encode_parts; kUnsupported for morph
// targets; kUsage if the memory does not suffice for the number of points.
Expected<std::vector<EncodeJob>> encode_large_primitives(const Document& document,
                                                         const EncodeDocumentOptions& options,
                                                         SelectedPrimitives& selected,
                                                         const OutOfCoreOptions& limits, const ThreadPool& pool,
                                                         const Progress& progress,
                                                         const std::function<void()>& forget);

}  // namespace psplit
