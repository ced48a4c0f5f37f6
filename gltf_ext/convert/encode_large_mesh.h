// Encodes a mesh part by part.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "gltf_ext/convert/encode_document_options.h"
#include "gltf_ext/convert/encode_job.h"
#include "gltf_ext/convert/select_primitives.h"
#include "gltf_ext/out_of_core/cell_assignment.h"
#include "gltf_ext/out_of_core/large_mesh.h"
#include "gltf_ext/out_of_core/mesh_spool.h"

namespace psplit {

// How the memory of the process is used.
struct MemoryPlan {
  uint64_t buffer_bytes = 0, most_zero_normals = 0;
  int thread_count = 1;  // fewer than wanted if their patches would take more than half of the memory
  uint64_t all = 0;      // for everything except the process itself
  PartCost cost;         // of a part
  uint64_t most_patch_faces = 0;
  uint64_t most_residue_points = 0, condensed_points = 0;  // see PartsOptions

  // `record_bytes`: of a point, or 0 if that is not known yet. Each thread encodes patches of `patch_faces`.
  MemoryPlan(const OutOfCoreOptions& limits, size_t record_bytes, int most_threads = 1,
             uint64_t patch_faces = 0);
};

// How a mesh file is read (read_spool) that encode_document gets with these options.
SpoolOptions spool_options(const EncodeDocumentOptions& options, const OutOfCoreOptions& limits);

// Encodes the large primitives, one after the other. The bytes of their jobs are in temporary files. Those that
// have nothing to encode are added to selected.skipped. `forget` is called when the values of one of them are
// not read any more; `progress` counts faces. Errors: those of CellParts and encode_parts; kUnsupported for
// morph targets; kUsage if the memory does not suffice for the number of points.
Expected<std::vector<EncodeJob>> encode_large_primitives(const Document& document,
                                                         const EncodeDocumentOptions& options,
                                                         SelectedPrimitives& selected,
                                                         const OutOfCoreOptions& limits, const ThreadPool& pool,
                                                         const Progress& progress,
                                                         const std::function<void()>& forget);

}  // namespace psplit
