// libpsplit_draco.so: takes the place of one function of a shared libdraco, by LD_PRELOAD or because it is
// linked before it.
//
//   LD_PRELOAD=libpsplit_draco.so draco_decoder -i dragon.drc -o dragon.obj
//
// PSPLIT_DRACO=off leaves everything to libdraco. PSPLIT_DRACO=verbose says on stderr who decoded each stream.
#include <dlfcn.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "psplit/decode.h"
#include "psplit/draco_decoder.h"

namespace {

enum class Mode { kOn, kOff, kVerbose };

Mode mode() {
  static const Mode chosen = [] {
    const char* const text = std::getenv("PSPLIT_DRACO");
    if (text != nullptr && std::strcmp(text, "off") == 0) return Mode::kOff;
    return text != nullptr && std::strcmp(text, "verbose") == 0 ? Mode::kVerbose : Mode::kOn;
  }();
  return chosen;
}

constexpr const char* kDecode =
    "_ZN5draco17PointCloudDecoder6DecodeERKNS_12DracoOptionsINS_17GeometryAttribute4TypeEEEPNS_"
    "13DecoderBufferEPNS_"
    "10PointCloudE";

}  // namespace

namespace draco {

// All of libdraco's ways to decode a mesh or a point cloud come here: MeshDecoder::Decode does nothing else
// than remember the mesh.
__attribute__((visibility("default"))) Status PointCloudDecoder::Decode(const DecoderOptions& options,
                                                                        DecoderBuffer* in_buffer,
                                                                        PointCloud* out_point_cloud) {
  const bool is_mesh = GetGeometryType() == TRIANGULAR_MESH;
  const auto bytes = static_cast<long long>(in_buffer->remaining_size());
  const bool is_decoded =
      mode() != Mode::kOff &&
      (is_mesh ? psplit::decode_into(*static_cast<Mesh*>(out_point_cloud), *in_buffer, options)
               : psplit::decode_into(*out_point_cloud, *in_buffer, options));
  if (mode() == Mode::kVerbose)
    std::fprintf(stderr, "psplit_draco: %lld bytes: %s\n", bytes, is_decoded ? "psplit" : "libdraco");
  // Programs that do not know of psplit cannot free what it keeps. Small streams leave little.
  constexpr long long kManyBytes = 1 << 18;
  if (is_decoded && bytes > kManyBytes) psplit::release_scratch();
  if (is_decoded) return OkStatus();

  using Function = Status (PointCloudDecoder::*)(const DecoderOptions&, DecoderBuffer*, PointCloud*);
  static void* const address = dlsym(RTLD_NEXT, kDecode);
  if (address == nullptr)
    return Status(Status::DRACO_ERROR, "psplit_draco: libdraco is not loaded behind libpsplit_draco.so");
  // In the Itanium ABI, a pointer to a function that is not virtual is its address and an offset of zero.
  Function next{};
  std::memcpy(&next, &address, sizeof address);
  return (this->*next)(options, in_buffer, out_point_cloud);
}

}  // namespace draco
