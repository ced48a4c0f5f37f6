#include "tools/gltf_psplit/compare/decode_as_loader.h"

#include <vector>

#include "src/container/patch_container.h"

namespace psplit {

Expected<DecodedCounts> decode_as_loader(std::span<const EncodedMesh> meshes, const DecodeBackend& backend,
                                         const ThreadPool& pool) {
  std::vector<PatchContainer> containers;
  containers.reserve(meshes.size());
  std::vector<DecodeTask> tasks;
  for (const EncodedMesh& mesh : meshes) {
    const EncodedPiece& piece = mesh.pieces.front();
    Expected<PatchContainer> container =
        piece.is_container ? open_container(piece.bytes) : open_stream(piece.bytes);
    if (!container) return container.status();
    containers.push_back(std::move(*container));
    tasks.push_back({&containers.back(), mesh.requests});
  }
  DecodedCounts counts;
  for (const Expected<Mesh>& mesh : backend.decode(tasks, pool)) {
    if (!mesh) return mesh.status();
    counts.faces += mesh->faces.size();
    counts.points += mesh->point_count;
  }
  return counts;
}

}  // namespace psplit
