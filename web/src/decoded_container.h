// An opened container, and the mesh that its patches become.
#pragma once

#include <memory>
#include <vector>

#include "src/container/decode_backend.h"
#include "src/container/patch_container.h"

namespace psplit::web {

class DecodedContainer {
 public:
  // Opens a container of any version. Any bytes may be given. Errors are those of open_container.
  static Expected<std::unique_ptr<DecodedContainer>> open(std::unique_ptr<uint8_t[]> bytes, size_t size);

  const PatchContainer& container() const { return container_; }

  // Requests an attribute for decode_all.
  void request(AttributeRequest request) { requests_.push_back(std::move(request)); }

  // Decodes all patches to mesh(). Errors are those of the CPU's backend, with the patch as their place.
  Status decode_all();
  const Mesh& mesh() const { return mesh_; }

 private:
  DecodedContainer() = default;

  std::unique_ptr<uint8_t[]> bytes_;
  PatchContainer container_;
  std::vector<AttributeRequest> requests_;
  Mesh mesh_;
};

}  // namespace psplit::web
