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

struct DecodeBackend {
  std::string name;
  // A container (src/container/container.h) to the stitched mesh. `requests` name every attribute wanted.
  std::function<Expected<Mesh>(std::span<const uint8_t> container, std::span<const AttributeRequest> requests,
                               const ThreadPool& pool)>
      decode_container;
  // One stock Draco mesh stream to a mesh.
  std::function<Expected<Mesh>(std::span<const uint8_t> stream, std::span<const AttributeRequest> requests)>
      decode_stream;
};

}  // namespace psplit
