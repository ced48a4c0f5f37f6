// What turns a container into a mesh. The loader takes its backend as a value; libdraco and CUDA register
// theirs from outside.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "src/export.h"
#include "src/mesh/mesh.h"
#include "src/parallel.h"
#include "src/status.h"

namespace psplit {

// Which Draco attribute becomes which glTF attribute.
struct AttributeRequest {
  std::string semantic;
  uint32_t unique_id = 0;
  ComponentType component_type = ComponentType::kFloat32;
  uint8_t component_count = 3;
  bool normalized = false;
};

// What becomes one mesh.
struct DecodeTask {
  std::span<const uint8_t> bytes;  // a container (src/container/container.h), or one stock Draco mesh stream
  bool is_stream = false;
  std::span<const AttributeRequest> requests;  // every attribute wanted
};

// Memory of the caller's that a mesh is written to.
struct MeshTarget {
  struct Values {
    std::byte* first = nullptr;  // the first point's; of any alignment
    size_t stride = 0;           // bytes from one point to the next
  };
  uint32_t point_count = 0, face_count = 0;  // the container's; of a stream, faces behind these are dropped
  void* indices = nullptr;                   // three for each face, aligned
  uint32_t index_bytes = 4;                  // 2, for no more than 65,535 points, or 4
  std::vector<Values> attributes;            // one for each request
};
PSPLIT_EXPORT MeshTarget target_of(Mesh& mesh);

// Called with the number of finished tasks and their total; may come from any thread.
using Progress = std::function<void(size_t done, size_t total)>;

// How a caller follows work, and ends it.
struct Watch {
  Progress progress{};                      // in the steps that a backend takes: patches, or tasks
  const std::atomic<bool>* stop = nullptr;  // true ends it; null for nobody

  bool stopped() const { return stop != nullptr && stop->load(std::memory_order_relaxed); }
};

struct PSPLIT_EXPORT DecodeBackend {
  std::string name;
  // A mesh, stitched, or an error for each task, in their order; one's error is no other's.
  std::function<std::vector<Expected<Mesh>>(std::span<const DecodeTask> tasks, const ThreadPool& pool,
                                            const Progress& progress)>
      decode;
  // The same into a target for each task, with no mesh between; may be left out. After an error a target holds
  // anything.
  std::function<std::vector<Status>(std::span<const DecodeTask> tasks, std::span<const MeshTarget> targets,
                                    const ThreadPool& pool, const Watch& watch)>
      decode_into{};

  // By decode_into, or by way of meshes, which take memory and end only when all are done. Errors: those of the
  // backend, kInvalidInput where a stream's counts are not the target's, kCancelled.
  std::vector<Status> decode_to(std::span<const DecodeTask> tasks, std::span<const MeshTarget> targets,
                                const ThreadPool& pool, const Watch& watch = {}) const;

  Expected<Mesh> decode_container(std::span<const uint8_t> container,
                                  std::span<const AttributeRequest> requests, const ThreadPool& pool) const;
  Expected<Mesh> decode_stream(std::span<const uint8_t> stream,
                               std::span<const AttributeRequest> requests) const;
};

// A backend that knows one task at a time. Both functions are called from many threads.
PSPLIT_EXPORT DecodeBackend one_by_one(
    std::string name,
    std::function<Expected<Mesh>(std::span<const uint8_t> container, std::span<const AttributeRequest> requests,
                                 const ThreadPool& pool)>
        decode_container,
    std::function<Expected<Mesh>(std::span<const uint8_t> stream, std::span<const AttributeRequest> requests)>
        decode_stream);

}  // namespace psplit
