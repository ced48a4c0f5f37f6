// The primitives of an asset as the benchmarks encode them.
#pragma once

#include <algorithm>
#include <vector>

#include "encoder/encode_mesh.h"
#include "gltf_ext/convert/read_jobs.h"
#include "psplit/document.h"
#include "psplit/encode.h"
#include "psplit/gltf.h"
#include "tools/gltf_psplit/compare/meshopt_rival.h"

namespace psplit {

// An asset's triangle primitives, as psplit and libdraco encode them, and meshoptimizer's encoding of them.
struct AssetPrimitives {
  std::vector<EncodeJob> jobs;
  std::vector<MeshoptMesh> meshopt;
  uint64_t faces = 0, most_faces = 0;
};

inline Expected<AssetPrimitives> read_asset_primitives(const Document& document,
                                                       const EncodeDocumentOptions& options,
                                                       const ThreadPool& pool) {
  Expected<PlannedJobs> jobs = read_and_plan(document, options, cpu_backend(), pool);
  if (!jobs) return jobs.status();
  AssetPrimitives out;
  for (EncodeJob& job : jobs->jobs) {
    const Mesh mesh = reduce(job.source, options, pool).mesh;
    if (mesh.faces.empty()) continue;
    Expected<MeshoptMesh> meshopt = encode_meshopt(mesh, job.source.codings);
    if (!meshopt) return meshopt.status();
    out.faces += mesh.faces.size();
    out.most_faces = std::max<uint64_t>(out.most_faces, mesh.faces.size());
    out.meshopt.push_back(std::move(*meshopt));
    out.jobs.push_back(std::move(job));
  }
  return out;
}

inline Expected<std::vector<EncodedMesh>> encode_asset_primitives(const AssetPrimitives& asset,
                                                                  const EncodeDocumentOptions& options,
                                                                  const ThreadPool& pool) {
  std::vector<EncodedMesh> out;
  for (const EncodeJob& job : asset.jobs) {
    Expected<EncodedMesh> mesh = encode(job.source, options, pool);
    if (!mesh) return mesh.status();
    out.push_back(std::move(*mesh));
  }
  return out;
}

inline Status decode_meshopt_all(std::span<const MeshoptMesh> meshes, MeshoptForm form) {
  for (const MeshoptMesh& mesh : meshes)
    if (const auto decoded = decode_meshopt(mesh, form); !decoded) return decoded.status();
  return {};
}

}  // namespace psplit
