#include <algorithm>
#include <array>
#include <optional>

#include "gltf_ext/content_hash.h"
#include "gltf_ext/document.h"
#include "gltf_ext/files.h"
#include "gltf_ext/glb.h"
#include "gltf_ext/json_fields.h"
#include "gltf_ext/json_text.h"
#include "gltf_ext/structure.h"
#include "gltf_ext/uri.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// glTF asks for 4; property tables of EXT_structural_metadata hold 8-byte values.
constexpr size_t kBufferAlignment = 8;

struct Merged {
  Json json;
  std::vector<uint8_t> bytes;
};

void move_range(Json& range, const std::vector<size_t>& new_buffer, const std::vector<size_t>& base) {
  const auto buffer = integer_field(range, "buffer");
  if (!buffer || *buffer < 0 || static_cast<uint64_t>(*buffer) >= base.size()) return;
  const auto old = static_cast<size_t>(*buffer);
  range["buffer"] = new_buffer[old];
  if (base[old] != 0)
    range["byteOffset"] = integer_field(range, "byteOffset").value_or(0) + static_cast<int64_t>(base[old]);
}

// All bytes in buffer 0. Fallback buffers, which have none, follow it.
Merged merge_buffers(const Document& document) {
  Merged merged{document.json, {}};
  const size_t count = document.buffers.size();
  if (count == 0) return merged;
  Json first, fallbacks = Json::array();
  std::vector<size_t> new_buffer(count, 0), base(count, 0);
  size_t total = 0;
  for (const auto& bytes : document.buffers)
    total += (bytes.size() + kBufferAlignment - 1) / kBufferAlignment * kBufferAlignment;
  merged.bytes.reserve(total);
  for (size_t i = 0; i < count; ++i) {
    const Json& buffer = document.json["buffers"][i];
    const std::vector<uint8_t>& bytes = document.buffers[i];
    if (bytes.empty() && integer_field(buffer, "byteLength").value_or(0) > 0) {
      new_buffer[i] = 1 + fallbacks.size();
      fallbacks.push_back(buffer);
      continue;
    }
    if (first.is_null()) first = buffer;
    merged.bytes.resize((merged.bytes.size() + kBufferAlignment - 1) / kBufferAlignment * kBufferAlignment);
    base[i] = merged.bytes.size();
    merged.bytes.insert(merged.bytes.end(), bytes.begin(), bytes.end());
  }
  merged.bytes.resize((merged.bytes.size() + 3) / 4 * 4);
  if (merged.bytes.empty() && array_size(merged.json, "bufferViews") > 0)
    merged.bytes.resize(4);  // views of length 0
  if (merged.bytes.empty()) {
    merged.json.erase("buffers");
    return merged;
  }
  if (first.is_null()) first = Json::object();
  first.erase("uri");
  // A fallback buffer that came with its bytes is an ordinary buffer once others share it.
  if (meshopt_extension(first) != nullptr) erase_meshopt_extension(first);
  first["byteLength"] = merged.bytes.size();
  Json buffers = Json::array();
  buffers.push_back(std::move(first));
  for (Json& fallback : fallbacks) buffers.push_back(std::move(fallback));
  merged.json["buffers"] = std::move(buffers);
  if (Json* views = array_field(merged.json, "bufferViews")) {
    for (Json& view : *views) {
      move_range(view, new_buffer, base);
      if (Json* meshopt = meshopt_extension(view)) move_range(*meshopt, new_buffer, base);
    }
  }
  return merged;
}

// Only files that are images by name: an asset must not choose what else gets overwritten in the output folder.
bool is_image_name(const fs::path& path) {
  constexpr std::array<std::string_view, 9> kImages = {".png", ".jpg",   ".jpeg", ".webp", ".ktx2",
                                                       ".ktx", ".basis", ".dds",  ".avif"};
  return std::find(kImages.begin(), kImages.end(), lower_extension(path)) != kImages.end();
}

// Images that are missing, or that lie outside the asset's folder, stay what they are: a URI.
Status copy_images(const Document& document, const fs::path& output) {
  if (document.source.empty() || document.source == "-") return {};
  std::error_code error;
  const fs::path from = fs::absolute(document.source, error).parent_path();
  const fs::path to = fs::absolute(output, error).parent_path();
  if (fs::equivalent(from, to, error)) return {};
  const Json* images = array_field(document.json, "images");
  if (images == nullptr) return {};
  for (const Json& image : *images) {
    const std::string* uri = string_field(image, "uri");
    if (uri == nullptr || is_data_uri(*uri)) continue;
    const auto relative = relative_path_of_uri(*uri);
    if (!relative || !is_image_name(*relative) || !fs::is_regular_file(from / *relative, error)) continue;
    const fs::path target = to / *relative;
    if (fs::equivalent(from / *relative, target, error)) continue;
    fs::create_directories(target.parent_path(), error);
    const auto bytes = read_file(from / *relative);
    if (!bytes) return bytes.status();
    if (Status status = write_file(target, {*bytes}); !status.ok()) return status;
  }
  return {};
}

// "name.0123456789abcdef.bin": by its content, so that it never replaces what a .gltf that still stands refers
// to.
constexpr size_t kNameDigits = 16;

fs::path binary_path(const fs::path& path, std::span<const uint8_t> bytes) {
  ContentHash hash;
  hash.add(bytes);
  fs::path binary = path;
  return binary.replace_extension("." + hash.hex().substr(0, kNameDigits) + ".bin");
}

// The binary of the .gltf that stands at `path`, where binary_path gave it its name: once the .gltf is replaced
// nothing needs it.
std::optional<fs::path> superseded_binary(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return std::nullopt;
  const auto bytes = read_file(path);
  if (!bytes) return std::nullopt;
  const auto json = parse_json({reinterpret_cast<const char*>(bytes->data()), bytes->size()});
  const Json* buffer = json ? top_level_object(*json, "buffers", 0) : nullptr;
  const std::string* uri = buffer == nullptr ? nullptr : string_field(*buffer, "uri");
  if (uri == nullptr) return std::nullopt;
  const fs::path binary = path.parent_path() / percent_decode(*uri);
  if (binary.parent_path() != path.parent_path() || asset_of_binary(binary) != path) return std::nullopt;
  return binary;
}

// Copies of a .gltf share its binary.
bool is_used_by_others(const fs::path& binary) {
  const std::string digits = binary.stem().extension().string();
  std::error_code error;
  for (fs::directory_iterator entry(binary.parent_path().empty() ? "." : binary.parent_path(), error), end;
       !error && entry != end; entry.increment(error)) {
    if (lower_extension(entry->path()) != ".gltf") continue;
    const auto bytes = read_file(entry->path());
    if (!bytes || std::string_view(reinterpret_cast<const char*>(bytes->data()), bytes->size()).find(digits) !=
                      std::string_view::npos)
      return true;
  }
  return false;
}

std::string dump(const Json& json, int indent) {
  return json.dump(indent, ' ', /*ensure_ascii=*/false, Json::error_handler_t::replace);
}

std::span<const uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

}  // namespace

std::optional<fs::path> asset_of_binary(const fs::path& binary) {
  const std::string digits = binary.stem().extension().string();  // with the dot before them
  if (binary.extension() != ".bin" || digits.size() != 1 + kNameDigits ||
      digits.find_first_not_of("0123456789abcdef", 1) != std::string::npos)
    return std::nullopt;
  fs::path asset = binary.parent_path() / binary.stem().stem();
  return asset += ".gltf";
}

Status write_document(const Document& document, const fs::path& path) {
  const bool to_stdout = path == "-";
  std::error_code is_no_link;
  if (!to_stdout && fs::is_symlink(path, is_no_link)) {  // what stands beside it stands beside its target
    const fs::path target = fs::weakly_canonical(path, is_no_link);
    if (!fs::is_symlink(target, is_no_link)) return write_document(document, target);
  }
  const bool glb = to_stdout || lower_extension(path) == ".glb";
  const Place place{.file = to_stdout ? "stdout" : path.string()};
  if (!glb && lower_extension(path) != ".gltf")
    return Status(StatusCode::kUsage, "an output is named .glb or .gltf", place);

  Merged merged = merge_buffers(document);
  if (glb) {
    const auto head = glb_head(dump(merged.json, -1), merged.bytes.size());
    if (!head) return head.status().at(place);
    if (!to_stdout)
      if (Status status = copy_images(document, path); !status.ok()) return std::move(status).at(place);
    return write_file(path, {*head, merged.bytes}).at(place);
  }

  // The binary first, under a name of its own: whatever .gltf stands at `path` meanwhile is whole.
  if (Status status = copy_images(document, path); !status.ok()) return std::move(status).at(place);
  const std::optional<fs::path> before = superseded_binary(path);
  std::optional<fs::path> binary_written;
  if (!merged.bytes.empty()) {
    const fs::path binary = binary_path(path, merged.bytes);
    binary_written = binary;
    merged.json["buffers"][0]["uri"] = percent_encode(binary.filename().string());
    if (Status status = write_file(binary, {merged.bytes}); !status.ok()) return std::move(status).at(place);
  }
  const std::string text = dump(merged.json, 2) + "\n";
  Status status = write_file(path, {bytes_of(text)}).at(place);
  std::error_code ignored;
  if (status.ok() && before && before != binary_written && !is_used_by_others(*before))
    fs::remove(*before, ignored);
  return status;
}

}  // namespace psplit
