#include "gltf_ext/convert/decode_to_file.h"

#include <algorithm>

#include "gltf_ext/convert/memory_model.h"
#include "src/container/claims.h"
#include "src/cpu/container_decoder.h"
#include "system/operating_system.h"

namespace psplit {
namespace {

void release(std::span<const std::byte> bytes) {
  release_mapped({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
}

}  // namespace

Status decode_into_file(const PatchContainer& container, std::span<const AttributeRequest> requests,
                        const LaidOutMesh& mesh, const MemoryLimit& limit, const ThreadPool& pool,
                        const Progress& progress, std::vector<StreamFindings>* findings) {
  const Watch watch{progress};
  Steps steps(watch, container.entries.size());
  const DecodeTask task{&container, requests};
  ContainerDecoder decoder(task, mesh.buffers, pool, steps, findings);
  const auto finish = [&](StreamRange window) {
    // The checks of copies also read values of earlier windows.
    for (const AttributeBuffer& attribute : mesh.buffers.attributes)
      release(attribute.bytes.first(container.owned_base[window.end] * attribute.stride));
    release(mesh.buffers.indices.first(size_t{3} * container.face_base[window.end] * mesh.buffers.index_bytes));
    release_mapped(container.bytes);
  };
  return decoder.decode_in_windows(std::max<uint64_t>(1, limit.bytes / 2 / kWindowFace), finish);
}

Expected<MeshInFile> decode_to_file(const PatchContainer& container, std::span<const AttributeRequest> requests,
                                    const MemoryLimit& limit, const ThreadPool& pool,
                                    std::vector<StreamFindings>* findings) {
  const uint32_t points = container.point_count(), faces = container.face_count();
  if (Status status = check_results(points, faces, requests, container.bytes.size()); !status.ok())
    return status;
  Expected<MeshInFile> mesh = lay_out_in_file(requests, points, faces, limit.folder);
  if (!mesh) return mesh;
  Status status = decode_into_file(container, requests, mesh->laid_out, limit, pool, {}, findings);
  if (!status.ok()) return status;
  return mesh;
}

}  // namespace psplit
