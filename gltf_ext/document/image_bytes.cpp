#include "gltf_ext/document/image_bytes.h"

#include <algorithm>
#include <set>
#include <string>

#include "gltf_ext/json/json_fields.h"
#include "system/operating_system.h"
#include "system/uri.h"

namespace psplit {

ImageBytes image_bytes(const Json& json, const std::filesystem::path& folder) {
  ImageBytes bytes;
  const Json* images = array_field(json, "images");
  if (images == nullptr) return bytes;
  std::set<int64_t> views;
  std::set<std::filesystem::path> names;
  for (const Json& image : *images) {
    if (const std::string* uri = string_field(image, "uri")) {
      if (is_data_uri(*uri)) bytes.in_json += uri->size();
      const std::filesystem::path name = is_data_uri(*uri) ? "" : path_of_uri(*uri, folder);
      if (is_data_uri(*uri) || !names.insert(name).second) continue;
      std::error_code error;
      const bool exists = is_disk_file(folder / name);
      const uint64_t file_bytes = exists ? std::filesystem::file_size(folder / name, error) : 0;
      if (exists && !error)
        bytes.in_files += file_bytes;
      else
        ++bytes.missing;
    } else if (const auto view = integer_field(image, "bufferView"); view && views.insert(*view).second) {
      if (const Json* found = top_level_object(json, "bufferViews", *view))
        bytes.in_buffers +=
            static_cast<uint64_t>(std::max<int64_t>(0, integer_field(*found, "byteLength").value_or(0)));
    }
  }
  return bytes;
}

}  // namespace psplit
