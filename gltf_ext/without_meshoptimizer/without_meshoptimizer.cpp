// What stands for meshoptimizer in a build without it. What only it decodes passes through.
#include <string>

#include "gltf_ext/convert/simplify.h"
#include "gltf_ext/document/meshopt_codec.h"
#include "gltf_ext/document/meshopt_library.h"

namespace psplit {

const char* why_meshopt_is_unreadable() {
  return "is compressed by meshoptimizer, and this psplit was built without it (PSPLIT_WITH_MESHOPTIMIZER=OFF)";
}

bool library_reads(const MeshoptRecord&, uint8_t) { return false; }
bool library_decode(const MeshoptRecord&, std::span<const uint8_t>, uint8_t*) { return false; }
Status check_meshopt_encoder() {
  return wrong_usage("this psplit was built without meshoptimizer (PSPLIT_WITH_MESHOPTIMIZER=OFF)");
}
std::vector<uint8_t> library_encode(const MeshoptRecord&, std::span<const uint8_t>) { return {}; }

// Not kUnsupported, which would leave the mesh as it is: the mesh is not the reason.
Expected<std::vector<Faces>> simplify(std::span<const Mesh>, uint64_t) { return check_meshopt_encoder(); }

}  // namespace psplit
