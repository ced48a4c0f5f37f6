// Encodes a mesh in temporary files part by part, and stores it in a document.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "encoder/out_of_core/encode_parts.h"
#include "gltf_ext/convert/encode_document_options.h"
#include "gltf_ext/convert/primitive_report.h"
#include "gltf_ext/document/document.h"
#include "gltf_ext/out_of_core/cell_assignment.h"
#include "gltf_ext/out_of_core/mesh_spool.h"
#include "gltf_ext/out_of_core/out_of_core_options.h"
#include "gltf_ext/primitive/primitive_edit.h"

namespace psplit {

// How the memory of the process is used.
struct MemoryPlan {
  uint64_t buffer_bytes = 0, most_zero_normals = 0;
  int thread_count = 1;  // fewer than wanted if their patches would take more than half of the memory
  uint64_t all = 0;      // for everything except the process itself
  PartCost cost;         // of a part

  // `record_bytes`: of a point, or 0 if that is not known yet. Each thread encodes patches of `patch_faces`.
  MemoryPlan(const OutOfCoreOptions& limits, size_t record_bytes, int most_threads = 1,
             uint64_t patch_faces = 0);
};

// A mesh in containers, and its reports. Several containers are on one grid.
struct EncodedSpool {
  std::vector<Attribute> attributes;  // without values
  EncodedParts encoded;
  // One for each container. The first has the counts of the input.
  std::vector<PrimitiveReport> reports;
};

// Closes the files of the finished `spool`. What the mesh loses is added to `losses`. `progress` counts faces.
// Errors: those of CellParts and encode_parts, kUsage if the memory does not suffice for the number of points.
Expected<EncodedSpool> encode_spool(MeshSpool& spool, const EncodeDocumentOptions& options,
                                    const OutOfCoreOptions& limits, Losses& losses, const ThreadPool& pool,
                                    const Progress& progress);

// Makes each group of primitives refer to one of the containers, as encode_document does. Their bytes become
// mapped temporary files in `folder`.
Status store_containers(Document& document, std::span<const PrimitiveGroup> groups, EncodedSpool& spool,
                        const std::filesystem::path& folder, std::span<const int64_t> freed = {});

// A mesh with the attributes of a container that has their bounds: two points and a face.
Mesh mesh_of_bounds(const PartsContainer& container, const std::vector<Attribute>& attributes);

}  // namespace psplit
