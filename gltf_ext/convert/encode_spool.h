// Encodes a mesh in temporary files part by part, and stores it in a document.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "encoder/encode_parts.h"
#include "gltf_ext/convert/encode_document_options.h"
#include "gltf_ext/convert/primitive_report.h"
#include "gltf_ext/document/document.h"
#include "gltf_ext/out_of_core/cell_assignment.h"
#include "gltf_ext/out_of_core/mesh_spool.h"
#include "gltf_ext/primitive/primitive_edit.h"

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

// A mesh in containers on one grid, or in streams without a container, and its report.
struct EncodedSpool {
  std::vector<Attribute> attributes;  // without values
  EncodedParts encoded;
  PrimitiveReport report;
};

// Closes the files of the finished `spool`. What the mesh loses is added to `losses`. `progress` counts faces.
// Errors: those of CellParts and encode_parts, kUsage if the memory does not suffice for the number of points.
Expected<EncodedSpool> encode_spool(MeshSpool& spool, const EncodeDocumentOptions& options,
                                    const OutOfCoreOptions& limits, Losses& losses, const ThreadPool& pool,
                                    const Progress& progress);

// Makes each group of primitives refer to one of the containers or streams. Their bytes become mapped temporary
// files, and so do their decoded meshes if there is a fallback.
Status store_containers(Document& document, std::span<const PrimitiveGroup> groups, EncodedSpool& spool,
                        const EncodeDocumentOptions& options, const OutOfCoreOptions& limits,
                        const ThreadPool& pool, PrimitiveEditor& editor);

}  // namespace psplit
