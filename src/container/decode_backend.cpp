#include "src/container/decode_backend.h"

#include <atomic>
#include <cstring>

#include "src/container/claims.h"

namespace psplit {
namespace {

Status copy_mesh(const Mesh& mesh, const MeshTarget& target) {
  if (mesh.point_count != target.point_count)
    return differs_from_directory("points", mesh.point_count, target.point_count);
  if (mesh.faces.size() < target.face_count)
    return differs_from_directory("faces", static_cast<uint32_t>(mesh.faces.size()), target.face_count);
  const auto copy_faces = [&]<typename Out>(Out* out) {
    for (uint32_t face = 0; face < target.face_count; ++face)
      for (const uint32_t point : mesh.faces[face]) *out++ = static_cast<Out>(point);
  };
  if (target.index_bytes == 2)
    copy_faces(static_cast<uint16_t*>(target.indices));
  else
    copy_faces(static_cast<uint32_t*>(target.indices));
  for (size_t k = 0; k < target.attributes.size(); ++k) {
    const auto [first, stride] = target.attributes[k];
    const size_t bytes = mesh.attributes[k].stride();
    if (stride == bytes && mesh.point_count > 0) {
      std::memcpy(first, mesh.attributes[k].values.data(), bytes * mesh.point_count);
      continue;
    }
    for (size_t point = 0; point < mesh.point_count; ++point)
      std::memcpy(first + point * stride, mesh.attributes[k].values.data() + point * bytes, bytes);
  }
  return {};
}

}  // namespace

MeshTarget target_of(Mesh& mesh) {
  MeshTarget target{mesh.point_count, static_cast<uint32_t>(mesh.faces.size()), mesh.faces.data(), 4, {}};
  for (Attribute& attribute : mesh.attributes)
    target.attributes.push_back({attribute.values.data(), attribute.stride()});
  return target;
}

std::vector<Status> DecodeBackend::decode_to(std::span<const DecodeTask> tasks,
                                             std::span<const MeshTarget> targets, const ThreadPool& pool,
                                             const Watch& watch) const {
  if (watch.stopped()) return std::vector<Status>(tasks.size(), cancelled());
  if (decode_into) return decode_into(tasks, targets, pool, watch);
  const std::vector<Expected<Mesh>> meshes = decode(tasks, pool, watch.progress);
  if (watch.stopped()) return std::vector<Status>(tasks.size(), cancelled());
  std::vector<Status> statuses(tasks.size());
  pool.for_each(tasks.size(), [&](size_t i) {
    statuses[i] = meshes[i] ? copy_mesh(*meshes[i], targets[i]) : meshes[i].status();
  });
  return statuses;
}

Expected<Mesh> DecodeBackend::decode_container(std::span<const uint8_t> container,
                                               std::span<const AttributeRequest> requests,
                                               const ThreadPool& pool) const {
  const DecodeTask task{container, false, requests};
  return std::move(decode({&task, 1}, pool, {}).front());
}

Expected<Mesh> DecodeBackend::decode_stream(std::span<const uint8_t> stream,
                                            std::span<const AttributeRequest> requests) const {
  const DecodeTask task{stream, true, requests};
  return std::move(decode({&task, 1}, ThreadPool(1), {}).front());
}

DecodeBackend one_by_one(
    std::string name,
    std::function<Expected<Mesh>(std::span<const uint8_t>, std::span<const AttributeRequest>,
                                 const ThreadPool&)>
        decode_container,
    std::function<Expected<Mesh>(std::span<const uint8_t>, std::span<const AttributeRequest>)> decode_stream) {
  return {std::move(name),
          [decode_container = std::move(decode_container), decode_stream = std::move(decode_stream)](
              std::span<const DecodeTask> tasks, const ThreadPool& pool, const Progress& progress) {
            std::vector<Expected<Mesh>> meshes(tasks.size(), Mesh());
            std::atomic<size_t> done = 0;
            pool.for_each(tasks.size(), [&](size_t i) {
              const DecodeTask& task = tasks[i];
              meshes[i] = task.is_stream ? decode_stream(task.bytes, task.requests)
                                         : decode_container(task.bytes, task.requests, pool);
              if (progress) progress(++done, tasks.size());
            });
            return meshes;
          },
          {}};
}

}  // namespace psplit
