#include "tools/gltf_psplit/report/asset_bytes.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "gltf_ext/files/files.h"
#include "gltf_ext/files/uri.h"
#include "gltf_ext/json/glb.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "tools/gltf_psplit/report/number_text.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// The sizes of files that relative URIs name. Each file counts once; a missing file counts 0.
class FilesBeside {
 public:
  explicit FilesBeside(const fs::path& asset) : folder_(asset.parent_path()) {}

  uint64_t bytes_of(const std::string& uri) {
    const std::string name = percent_decode(uri);
    std::error_code error;
    if (!counted_.insert(name).second || !fs::is_regular_file(folder_ / name, error)) return 0;
    const uintmax_t bytes = fs::file_size(folder_ / name, error);
    return error ? 0 : bytes;
  }

 private:
  fs::path folder_;
  std::set<std::string> counted_;
};

// Adds the images. Only images in files of their own add to `files`; the others are part of it already.
void add_images(const Json& json, FilesBeside& beside, AssetBytes& bytes) {
  const Json* images = array_field(json, "images");
  if (images == nullptr) return;
  std::set<int64_t> counted_views;
  for (const Json& image : *images) {
    if (const std::string* uri = string_field(image, "uri")) {
      const uint64_t image_bytes = is_data_uri(*uri) ? uri->size() : beside.bytes_of(*uri);
      bytes.textures += image_bytes;
      if (!is_data_uri(*uri)) bytes.files += image_bytes;
    } else if (const auto index = integer_field(image, "bufferView");
               index && counted_views.insert(*index).second) {
      const Json* view = top_level_object(json, "bufferViews", *index);
      const auto length = view == nullptr ? std::nullopt : integer_field(*view, "byteLength");
      bytes.textures += static_cast<uint64_t>(std::max<int64_t>(0, length.value_or(0)));
    }
  }
}

// The JSON of an asset. Of a GLB, only the header and the JSON chunk are read; of a file that begins neither
// like a GLB nor like JSON, only the first bytes.
Expected<Json> read_json(const std::string& path) {
  constexpr uint64_t kHead = 20, kLengthOffset = 12;  // the GLB header, and the header of the JSON chunk
  auto bytes = read_file(path, kHead);
  if (!bytes) return bytes.status();
  const auto first = std::ranges::find_if(*bytes, [](uint8_t byte) { return byte > ' ' && byte < 0x80; });
  if (!is_glb(*bytes) && (first == bytes->end() || *first != '{')) return invalid_input("not glTF");
  if (!is_glb(*bytes) || bytes->size() < kHead) {
    bytes = read_file(path);
    if (!bytes) return bytes.status();
    return parse_json({reinterpret_cast<const char*>(bytes->data()), bytes->size()});
  }
  uint64_t length = 0;
  for (size_t i = 4; i-- > 0;) length = length << 8 | (*bytes)[kLengthOffset + i];
  bytes = read_file(path, kHead + length);
  if (!bytes) return bytes.status();
  return parse_json({reinterpret_cast<const char*>(bytes->data()) + kHead, bytes->size() - kHead});
}

}  // namespace

AssetBytes bytes_on_disk(const std::string& path) {
  std::error_code error;
  if (path == "-" || !fs::is_regular_file(path, error)) return {};
  AssetBytes bytes{fs::file_size(path, error), 0};
  if (error) return {};
  const Expected<Json> json = read_json(path);
  if (!json) return bytes;  // a mesh file refers to no other files
  FilesBeside beside(path);
  if (const Json* buffers = array_field(*json, "buffers"))
    for (const Json& buffer : *buffers)
      if (const std::string* uri = string_field(buffer, "uri"); uri != nullptr && !is_data_uri(*uri))
        bytes.files += beside.bytes_of(*uri);
  add_images(*json, beside, bytes);
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
