#include "mesh_files/asset_format.h"

#include <algorithm>
#include <array>

#include "gltf_ext/json/glb.h"
#include "gltf_ext/json/text_encoding.h"
#include "mesh_files/draco_file.h"
#include "mesh_files/obj.h"
#include "mesh_files/off.h"
#include "mesh_files/ply.h"
#include "mesh_files/stl.h"
#include "system/files.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

struct Extension {
  std::string_view text;
  AssetFormat format;
};
constexpr std::array<Extension, 7> kExtensions = {{{".gltf", AssetFormat::kGltf},
                                                   {".glb", AssetFormat::kGltf},
                                                   {".drc", AssetFormat::kDraco},
                                                   {".ply", AssetFormat::kPly},
                                                   {".obj", AssetFormat::kObj},
                                                   {".stl", AssetFormat::kStl},
                                                   {".off", AssetFormat::kOff}}};

fs::path without_gz(const fs::path& path) {
  return lower_extension(path) == ".gz" ? path.parent_path() / path.stem() : path;
}

std::optional<AssetFormat> format_of_name(const fs::path& path) {
  const std::string extension = lower_extension(without_gz(path));
  const auto found = std::ranges::find(kExtensions, extension, &Extension::text);
  return found == kExtensions.end() ? std::nullopt : std::optional(found->format);
}

// The first word of the first line in the window that is not a comment.
std::string_view first_word(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n\v\f";
  for (size_t at = 0; at < text.size();) {
    const size_t begin = text.find_first_not_of(kBlanks, at);
    if (begin == std::string_view::npos) return {};
    if (text[begin] != '#') {
      const size_t end = text.find_first_of(kBlanks, begin);
      return text.substr(begin, std::min(end, text.size()) - begin);
    }
    at = std::min(text.find_first_of("\r\n", begin), text.size());
  }
  return {};
}

bool is_obj_keyword(std::string_view word) {
  constexpr std::array<std::string_view, 11> kKeywords = {"v", "vt", "vn", "vp", "f",     "o",
                                                          "g", "s",  "l",  "p",  "usemtl"};
  return word == "mtllib" || std::ranges::find(kKeywords, word) != kKeywords.end();
}

std::optional<AssetFormat> format_of_content(Scanner& scanner) {
  if (has_size_of_binary_stl(scanner)) return AssetFormat::kStl;
  std::string_view head = scanner.peek(size_t{1} << 16);
  const std::span<const uint8_t> bytes(reinterpret_cast<const uint8_t*>(head.data()), head.size());
  if (is_glb(bytes)) return AssetFormat::kGltf;
  if (is_draco(bytes)) return AssetFormat::kDraco;
  if (is_text_stl(scanner)) return AssetFormat::kStl;
  head = scanner.peek(size_t{1} << 16);
  if (head.starts_with("ply\n") || head.starts_with("ply\r") || head.starts_with("ply "))
    return AssetFormat::kPly;
  const std::string_view word = first_word(head);
  if (word.starts_with('{')) return AssetFormat::kGltf;
  if (is_off_keyword(word)) return AssetFormat::kOff;
  if (is_obj_keyword(word)) return AssetFormat::kObj;
  return std::nullopt;
}

}  // namespace

std::optional<AssetFormat> format_of(Scanner& scanner, const fs::path& source) {
  const std::optional<AssetFormat> format = format_of_content(scanner);
  return format ? format : format_of_name(source);
}

Expected<Scanner> open_scanner(std::unique_ptr<ByteStream> stream) {
  std::vector<uint8_t> head(3);
  size_t count = 0;
  for (size_t got = 1; got > 0 && count < head.size(); count += got)
    got = stream->read(std::span(head).subspan(count));
  head.resize(count);
  const bool packed = is_gzip(head);
  stream = join_streams(std::move(head), std::move(stream));
  if (packed) stream = unpack_gzip(std::move(stream));
  Scanner scanner(std::move(stream));
  if (scanner.at_end()) return scanner.failure().ok() ? invalid_input("the file is empty") : scanner.failure();
  if (has_size_of_binary_stl(scanner)) return scanner;  // its header may be any bytes
  const std::string_view text = scanner.peek(size_t{1} << 6);
  if (Status status = check_text_encoding(text); !status.ok()) return status;
  scanner.skip(text.size() - without_byte_order_mark(text).size());
  return scanner;
}

bool is_asset_name(const fs::path& path) { return format_of_name(path).has_value(); }

fs::path without_asset_extensions(const fs::path& path) {
  const fs::path unpacked = is_asset_name(path) ? without_gz(path) : path;
  return unpacked.parent_path() / unpacked.stem();
}

std::string asset_extensions_text() {
  std::string text;
  for (const Extension& extension : kExtensions)
    text += (text.empty() ? "" : ", ") + std::string(extension.text);
  return text;
}

}  // namespace psplit
