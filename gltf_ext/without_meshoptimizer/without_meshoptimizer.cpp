// What stands for meshoptimizer in a build without it.
#include <string>

#include "gltf_ext/convert/simplify.h"
#include "gltf_ext/document/asset_records.h"
#include "gltf_ext/document/read_steps.h"

namespace psplit {
namespace {

const std::string kNoMeshoptimizer =
    "this psplit was built without meshoptimizer (PSPLIT_WITH_MESHOPTIMIZER=OFF)";

}  // namespace

Status decode_meshopt_views(Document& document) {
  const std::vector<ViewRecord> views = document.records().views;
  for (size_t i = 0; i < views.size(); ++i)
    if (views[i].meshopt)
      return unsupported("buffer view " + std::to_string(i) + " is compressed by meshoptimizer, and " +
                         kNoMeshoptimizer);
  return {};
}

// Not kUnsupported: the mesh is not what is refused, so it is not left as it is.
Expected<std::vector<Faces>> simplify(std::span<const Mesh>, uint64_t) { return wrong_usage(kNoMeshoptimizer); }

}  // namespace psplit
