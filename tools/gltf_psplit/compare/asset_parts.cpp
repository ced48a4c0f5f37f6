#include "tools/gltf_psplit/compare/asset_parts.h"

#include <algorithm>

#include "gltf_ext/convert/sparse_targets.h"
#include "gltf_ext/document/image_bytes.h"
#include "gltf_ext/json/json_text.h"
#include "gltf_ext/primitive/geometry_bytes.h"

namespace psplit {
AssetParts measure_parts(const Document& document, std::span<const PrimitiveId> primitives) {
  const ImageBytes images = image_bytes(document.json(), document.source.parent_path());
  AssetParts parts;
  parts.meshes = geometry_bytes(document, primitives);
  parts.textures = images.total();
  parts.missing_images = images.missing;
  const std::string json = json_line(document.json());
  uint64_t all = json.size() + images.in_files;
  for (const BufferRecord& buffer : document.records().buffers) all += buffer.bytes;
  // Accessors may overlap.
  parts.rest = all - std::min(all, parts.meshes + parts.textures);
  parts.morph_targets = count_targets(document).all;
  return parts;
}

}  // namespace psplit
