#include "src/container/decode_backend.h"

#include <atomic>

namespace psplit {

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
          }};
}

}  // namespace psplit
