// What turns a container into a mesh. The loader takes its backend as a value; libdraco and CUDA register
// theirs from outside.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

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

// Called with the number of finished tasks and their total; may come from any thread.
using Progress = std::function<void(size_t done, size_t total)>;

struct DecodeBackend {
  std::string name;
  // A mesh, stitched, or an error for each task, in their order; one's error is no other's.
  std::function<std::vector<Expected<Mesh>>(std::span<const DecodeTask> tasks, const ThreadPool& pool,
                                            const Progress& progress)>
      decode;

  Expected<Mesh> decode_container(std::span<const uint8_t> container,
                                  std::span<const AttributeRequest> requests, const ThreadPool& pool) const;
  Expected<Mesh> decode_stream(std::span<const uint8_t> stream,
                               std::span<const AttributeRequest> requests) const;
};

// A backend that knows one task at a time. Both functions are called from many threads.
DecodeBackend one_by_one(
    std::string name,
    std::function<Expected<Mesh>(std::span<const uint8_t> container, std::span<const AttributeRequest> requests,
                                 const ThreadPool& pool)>
        decode_container,
    std::function<Expected<Mesh>(std::span<const uint8_t> stream, std::span<const AttributeRequest> requests)>
        decode_stream);

}  // namespace psplit
