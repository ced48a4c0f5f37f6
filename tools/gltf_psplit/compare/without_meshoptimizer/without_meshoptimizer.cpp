// What stands for meshoptimizer and zstd in a build without them.
#include "tools/gltf_psplit/compare/meshopt_rival.h"

namespace psplit {
namespace {

constexpr const char* kNoRival =
    "this psplit was built without meshoptimizer and zstd (PSPLIT_WITH_MESHOPTIMIZER=OFF)";

}  // namespace

Expected<MeshoptMesh> encode_meshopt(const Mesh&, std::span<const AttributeCoding>) {
  return wrong_usage(kNoRival);
}
Expected<MeshoptDecoded> decode_meshopt(const MeshoptMesh&, MeshoptForm) { return wrong_usage(kNoRival); }
std::string meshopt_version() { return ""; }
int meshopt_codec_version() { return 0; }
std::string zstd_version() { return ""; }
std::string brotli_version() { return ""; }
std::span<const MeshoptForm> meshopt_forms() { return {}; }

}  // namespace psplit
