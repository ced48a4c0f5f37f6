#include "psplit/decode.h"
#include "src/container/claims.h"

namespace psplit {

std::vector<Expected<Mesh>> DecodeBackend::decode(Span<const DecodeTask> tasks, const ThreadPool& pool,
                                                  const Progress& progress) const {
  std::vector<Mesh> meshes(tasks.size());
  const auto allocate = [&](size_t i, uint32_t point_count, uint32_t face_count) {
    const DecodeTask& task = tasks[i];
    return allocate_mesh(point_count, face_count, task.requests, task.container->bytes.size(), meshes[i]);
  };
  std::vector<Status> statuses = decode_into(tasks, allocate, pool, {progress});
  std::vector<Expected<Mesh>> results;
  results.reserve(tasks.size());
  for (size_t i = 0; i < tasks.size(); ++i)
    results.push_back(statuses[i].ok() ? Expected<Mesh>(std::move(meshes[i])) : std::move(statuses[i]));
  return results;
}

Expected<Mesh> DecodeBackend::decode(const PatchContainer& container, Span<const AttributeRequest> requests,
                                     const ThreadPool& pool) const {
  const DecodeTask task{&container, requests};
  return std::move(decode({&task, 1}, pool).front());
}

Expected<PrimitiveBuffers> allocate_mesh(uint32_t point_count, uint32_t face_count,
                                         Span<const AttributeRequest> requests, uint64_t stored_bytes,
                                         Mesh& mesh) {
  if (Status status = check_results(point_count, face_count, requests, stored_bytes); !status.ok())
    return status;
  mesh.point_count = point_count;
  mesh.faces.resize(face_count);
  mesh.attributes.clear();
  PrimitiveBuffers buffers{mesh.faces, sizeof(uint32_t)};
  for (const AttributeRequest& request : requests) {
    mesh.attributes.push_back(
        {request.semantic, request.component_type, request.component_count, request.normalized, {}});
    Array<std::byte>& values = mesh.attributes.back().values;
    values.resize(point_count * request.value_bytes());
    buffers.attributes.push_back({values, request.value_bytes()});
  }
  return buffers;
}

}  // namespace psplit
