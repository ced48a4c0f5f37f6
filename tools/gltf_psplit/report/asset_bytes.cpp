#include "tools/gltf_psplit/report/asset_bytes.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "gltf_ext/document/image_bytes.h"
#include "gltf_ext/json/glb.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "system/files.h"
#include "system/operating_system.h"
#include "system/uri.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// The bytes of the files of buffers. Each file counts once; a missing file counts 0.
uint64_t buffer_file_bytes(const Json& json, const fs::path& folder) {
  const Json* buffers = array_field(json, "buffers");
  if (buffers == nullptr) return 0;
  std::set<fs::path> names;
  for (const Json& buffer : *buffers)
    if (const std::string* uri = string_field(buffer, "uri"); uri != nullptr && !is_data_uri(*uri))
      names.insert(path_of_uri(*uri, folder));
  uint64_t bytes = 0;
  for (const fs::path& name : names) {
    std::error_code error;
    const uintmax_t file_bytes = is_disk_file(folder / name) ? fs::file_size(folder / name, error) : 0;
    if (!error) bytes += file_bytes;
  }
  return bytes;
}

}  // namespace

Expected<Json> read_asset_json(const std::string& path) {
  constexpr uint64_t kHead = 20, kLengthOffset = 12;  // the GLB header, and the header of the JSON chunk
  constexpr uint64_t kFirst = 4096;                   // has the whole JSON of small assets
  auto bytes = read_file(path, kFirst);
  if (!bytes) return bytes.status();
  if (!begins_as_gltf(*bytes)) return invalid_input("not glTF");
  const bool binary = is_glb(*bytes) && bytes->size() >= kHead;
  uint64_t end = UINT64_MAX;
  if (binary) {
    end = 0;
    for (size_t i = 4; i-- > 0;) end = end << 8 | (*bytes)[kLengthOffset + i];
    end += kHead;
  }
  if (bytes->size() == kFirst && end > kFirst) bytes = read_file(path, end);
  if (!bytes) return bytes.status();
  const size_t begin = binary ? kHead : 0, length = std::min<uint64_t>(end, bytes->size()) - begin;
  return parse_json({reinterpret_cast<const char*>(bytes->data()) + begin, length});
}

AssetBytes bytes_on_disk(const std::string& path) { return bytes_on_disk(path, read_asset_json(path)); }

AssetBytes bytes_on_disk(const std::string& path, const Expected<Json>& json) {
  std::error_code error;
  AssetBytes bytes{path == "-" ? 0 : fs::file_size(path, error), 0};
  if (path == "-" || error) return {};  // or a pipe
  if (!json) return bytes;              // a mesh file refers to no other files
  const fs::path folder = fs::path(path).parent_path();
  bytes.files += buffer_file_bytes(*json, folder);
  const ImageBytes images = image_bytes(*json, folder);
  bytes.files += images.in_files;
  bytes.textures = images.total();
  return bytes;
}

AssetBytes bytes_on_disk(const Document& document) {
  std::error_code error;
  if (document.source == "-" || !is_disk_file(document.source)) return {};
  AssetBytes bytes;
  for (const fs::path& file : std::set<fs::path>(document.files.begin(), document.files.end()))
    if (const uintmax_t size = fs::file_size(file, error); !error) bytes.files += size;
  const ImageBytes images = image_bytes(document.json(), document.source.parent_path());
  bytes.files += images.in_files;
  bytes.textures = images.total();
  return bytes;
}

std::string sizes_text(const AssetSizes& sizes) {
  const auto& [input, output] = sizes;
  if (output.files == 0) return "";
  std::string text = as_bytes(output.files);
  if (input.files > 0) {
    const double ratio = static_cast<double>(output.files) / static_cast<double>(input.files);
    text += " from " + as_bytes(input.files) +
            (ratio < 2 ? " (" + as_share(ratio) + ")" : " (" + with_decimals(ratio, 1) + " times)");
  }
  if (input.textures == 0 && output.textures == 0) return text;
  text += ", of which textures " + as_bytes(output.textures);
  return input.files == 0 || input.textures == output.textures ? text
                                                               : text + " from " + as_bytes(input.textures);
}

std::string written_text(const std::string& output, const AssetSizes& sizes, const std::string& done) {
  const std::string bytes = sizes_text(sizes);
  return (output == "-" ? "stdout" : output) + ": " + bytes + (bytes.empty() ? "" : "; ") + done;
}

Json sizes_json(const AssetSizes& sizes) {
  const auto side = [](const AssetBytes& bytes) {
    if (bytes.files == 0) return Json(nullptr);
    return Json{{"bytes", bytes.files}, {"texture_bytes", bytes.textures}};
  };
  Json json{{"input", side(sizes.input)}, {"output", side(sizes.output)}, {"ratio", nullptr}};
  if (sizes.input.files > 0 && sizes.output.files > 0)
    json["ratio"] = static_cast<double>(sizes.output.files) / static_cast<double>(sizes.input.files);
  return json;
}

}  // namespace psplit
