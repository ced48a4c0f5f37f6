#include "tools/gltf_psplit/compare/asset_parts.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>

#include "gltf_ext/document/element_layout.h"
#include "gltf_ext/files/uri.h"
#include "gltf_ext/json/json_fields.h"

namespace psplit {
namespace {

uint64_t count_field(const Json& object, const char* name) {
  return static_cast<uint64_t>(std::max<int64_t>(0, integer_field(object, name).value_or(0)));
}

uint64_t accessor_bytes(const Json& json, int64_t index) {
  const Json* accessor = top_level_object(json, "accessors", index);
  if (accessor == nullptr || field(*accessor, "bufferView") == nullptr) return 0;
  const Expected<ElementLayout> layout = element_layout(*accessor);
  return layout ? count_field(*accessor, "count") * layout->stored_bytes() : 0;
}

uint64_t mesh_bytes(const Json& json, std::span<const PrimitiveId> primitives) {
  std::set<int64_t> accessors;
  const auto add = [&](std::optional<int64_t> index) {
    if (index) accessors.insert(*index);
  };
  for (const PrimitiveId id : primitives) {
    const Json& primitive = json.at("meshes").at(id.mesh).at("primitives").at(id.primitive);
    add(integer_field(primitive, "indices"));
    if (const Json* attributes = object_field(primitive, "attributes"))
      for (const Json& index : *attributes) add(integer_value(index));
  }
  uint64_t bytes = 0;
  for (const int64_t index : accessors) bytes += accessor_bytes(json, index);
  return bytes;
}

// Bytes of images, by their place. Those in the JSON are part of its text.
struct ImageBytes {
  uint64_t in_json = 0, in_buffers = 0, beside = 0;
  uint64_t missing = 0;  // number of images
};

ImageBytes image_bytes(const Document& document) {
  ImageBytes bytes;
  const Json* images = array_field(document.json, "images");
  if (images == nullptr) return bytes;
  const std::filesystem::path folder = document.source.parent_path();
  std::set<int64_t> views;
  std::set<std::string> uris;
  for (const Json& image : *images) {
    if (const std::string* uri = string_field(image, "uri")) {
      if (is_data_uri(*uri)) bytes.in_json += uri->size();
      if (is_data_uri(*uri) || !uris.insert(*uri).second) continue;
      std::error_code error;
      const std::filesystem::path file = folder / percent_decode(*uri);
      const bool is_there = std::filesystem::is_regular_file(file, error);
      const uint64_t file_bytes = is_there ? std::filesystem::file_size(file, error) : 0;
      if (is_there && !error)
        bytes.beside += file_bytes;
      else
        ++bytes.missing;
    } else if (const auto view = integer_field(image, "bufferView"); view && views.insert(*view).second) {
      if (const Json* found = top_level_object(document.json, "bufferViews", *view))
        bytes.in_buffers += count_field(*found, "byteLength");
    }
  }
  return bytes;
}

}  // namespace

AssetParts measure_parts(const Document& document, std::span<const PrimitiveId> primitives) {
  const ImageBytes images = image_bytes(document);
  AssetParts parts;
  parts.meshes = mesh_bytes(document.json, primitives);
  parts.textures = images.in_json + images.in_buffers + images.beside;
  parts.missing_images = images.missing;
  const std::string json = document.json.dump(-1, ' ', false, Json::error_handler_t::replace);
  uint64_t all = json.size() + images.beside;
  if (const Json* buffers = array_field(document.json, "buffers"))
    for (const Json& buffer : *buffers) all += count_field(buffer, "byteLength");
  // Accessors may overlap.
  parts.rest = all - std::min(all, parts.meshes + parts.textures);
  return parts;
}

}  // namespace psplit
