// What the bytes of a whole asset are: meshes, which psplit makes smaller, and textures and all else, which it
// leaves as they are.
#pragma once

#include <cstdint>
#include <span>

#include "gltf_ext/primitive/read_primitives.h"

namespace psplit {

// Of an asset that nothing compresses: its JSON, its buffers, and its images, embedded or beside it.
struct AssetParts {
  uint64_t meshes = 0;    // indices and attributes of the primitives that were asked for, each accessor once
  uint64_t textures = 0;  // images as they are stored: PNG, JPEG, KTX ...
  uint64_t rest = 0;      // JSON, animations, skins, morph targets, other primitives, padding
  uint64_t missing_images = 0;  // images whose files are not there, so that their bytes are not in the sum

  uint64_t total() const { return with_meshes(meshes); }
  // Of the asset whose meshes take so many bytes.
  uint64_t with_meshes(uint64_t bytes) const { return bytes + textures + rest; }
};

AssetParts measure_parts(const Document& document, std::span<const PrimitiveId> primitives);

}  // namespace psplit
