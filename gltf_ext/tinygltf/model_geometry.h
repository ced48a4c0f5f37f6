// The primitives of a tinygltf::Model that the two Draco extensions store, opened but not decoded.
#pragma once

#include "gltf_ext/json/extension_names.h"
#include "psplit/tinygltf.h"

namespace psplit {

// If a primitive has both, the first counts.
inline constexpr const char* kDracoExtensions[] = {kExtensionName, kStockExtensionName};

struct PrimitivePlace {
  size_t mesh = 0, primitive = 0;

  Place place() const {
    return {.mesh = static_cast<int64_t>(mesh), .primitive = static_cast<int64_t>(primitive)};
  }
};

// One container or stream, and the primitives that use it in the same way.
struct ModelGeometry {
  std::vector<PrimitivePlace> users;  // at least one
  int view = -1;                      // of its bytes
  int indices = -1;                   // the accessor; -1 if the primitives have none
  uint32_t index_bytes = 4;           // 2 or 4
  std::vector<int> accessors;         // one for each attribute that the extension stores
  CompressedPrimitive stored;
};

// All geometries of the model. Errors name mesh and primitive. The result points into the model's buffers.
Expected<std::vector<ModelGeometry>> find_geometries(const tinygltf::Model& model, const ModelOptions& options);

}  // namespace psplit
