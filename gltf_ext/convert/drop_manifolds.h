// EXT_mesh_manifold names points by indices: it is lost when the points of a mesh change.
#pragma once

#include <span>

#include "gltf_ext/convert/encode_job.h"
#include "gltf_ext/convert/encode_reports.h"

namespace psplit {

// Drops EXT_mesh_manifold from the meshes of all jobs, releases its accessors, and adds a warning to the report
// of each primitive.
void drop_manifolds(Document& document, std::span<const EncodeJob> jobs, PrimitiveEditor& editor,
                    EncodeReports& reports);

}  // namespace psplit
