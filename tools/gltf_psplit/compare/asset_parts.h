// The parts of a whole asset in bytes: meshes, which psplit compresses, and textures and the rest, which it
// leaves as they are.
#pragma once

#include <cstdint>
#include <span>

#include "gltf_ext/primitive/read_primitives.h"

namespace psplit {

// The parts of an uncompressed asset: its JSON, its buffers, and its images, embedded or in files beside it.
struct AssetParts {
  uint64_t meshes = 0;          // indices and attributes of the requested primitives, each accessor once
  uint64_t textures = 0;        // images as they are stored: PNG, JPEG, KTX ...
  uint64_t rest = 0;            // JSON, animations, skins, morph targets, other primitives, padding
  uint64_t missing_images = 0;  // number of images without a file; their bytes are unknown
  uint64_t morph_targets = 0;   // number of their attributes; plain in `rest`

  uint64_t total() const { return with_meshes(meshes); }
  // The total if the meshes took `bytes` bytes.
  uint64_t with_meshes(uint64_t bytes) const { return bytes + textures + rest; }
};

AssetParts measure_parts(const Document& document, std::span<const PrimitiveId> primitives);

}  // namespace psplit
