// What stands for encoder/libdraco in a build without libdraco.
#include "encoder/libdraco/draco_backend.h"
#include "encoder/libdraco/patch_stream.h"
#include "psplit/encode.h"

namespace psplit {
namespace {

constexpr const char* kNoDraco = "this psplit was built without libdraco (PSPLIT_WITH_DRACO=OFF)";

std::vector<Status> decode_nothing(Span<const DecodeTask> tasks, const BuffersFor&, const ThreadPool&,
                                   const Watch&) {
  return std::vector<Status>(tasks.size(), unsupported(kNoDraco));
}

}  // namespace

DecodeBackend draco_backend() { return {"draco", decode_nothing}; }
std::string draco_version() { return ""; }
const OlderStreams* older_streams() { return nullptr; }
Expected<Mesh> decode_draco_stream(Span<const uint8_t>, Span<const AttributeRequest>) {
  return unsupported(kNoDraco);
}
Expected<StreamDescription> describe_draco_stream(Span<const uint8_t>) { return unsupported(kNoDraco); }

// Not kUnsupported, which would leave the mesh as it is: the mesh is not the reason.
Expected<EncodedPatch> encode_edgebreaker(const WeldedMesh&, const PatchMesh&, std::span<const AttributeCoding>,
                                          int, bool) {
  return wrong_usage(kNoDraco);
}
Expected<std::vector<uint8_t>> encode_sequential(const WeldedMesh&, const PatchMesh&,
                                                 std::span<const AttributeCoding>, int) {
  return wrong_usage(kNoDraco);
}

}  // namespace psplit
