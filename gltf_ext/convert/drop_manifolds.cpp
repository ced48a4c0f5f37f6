#include "gltf_ext/convert/drop_manifolds.h"

#include <set>

#include "gltf_ext/json/json_fields.h"

namespace psplit {

void drop_manifolds(Document& document, std::span<const EncodeJob> jobs, PrimitiveEditor& editor,
                    EncodeReports& reports) {
  constexpr const char* kManifold = "EXT_mesh_manifold";
  std::set<size_t> dropped;
  for (const EncodeJob& job : jobs) {
    if (job.keeps_stream) continue;  // and with it the order of points
    for (const PrimitiveId id : job.group.ids) {
      Json& mesh = document.json()["meshes"][id.mesh];
      if (const Json* manifold = extension_field(mesh, kManifold)) {
        for (const char* name : {"mergeIndices", "mergeValues"})
          if (const auto accessor = integer_field(*manifold, name)) editor.release(*accessor);
        if (const Json* primitive = object_field(*manifold, "manifoldPrimitive"))
          if (const auto accessor = integer_field(*primitive, "indices")) editor.release(*accessor);
        mesh["extensions"].erase(kManifold);
        if (mesh["extensions"].empty()) mesh.erase("extensions");
        dropped.insert(id.mesh);
      }
      if (dropped.contains(id.mesh))
        reports[id].warnings.push_back(std::string(kManifold) + " is dropped: its data refer to indices");
    }
  }
  if (!dropped.empty()) unlist_unused_extension(document, kManifold);
}

}  // namespace psplit
