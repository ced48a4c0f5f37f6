#include "tools/gltf_psplit/batch/manifest.h"

#include <cerrno>
#include <cstdio>
#include <memory>
#include <vector>

#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"
#include "system/content_hash.h"
#include "system/files.h"
#include "system/io_error.h"
#include "system/operating_system.h"
#include "system/uri.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMark = "gltf_psplit_plan";

bool write_lines(std::FILE* file, const ManifestHead& head, std::span<const BatchItem> items) {
  const auto write = [&](const Json& json) {
    const std::string line = json_line(json) + "\n";
    return std::fwrite(line.data(), 1, line.size(), file) == line.size();
  };
  if (!write({{kMark, 1}, {"version", head.version}, {"options", head.options}, {"count", head.count}}))
    return false;
  for (const BatchItem& item : items)
    if (!write(to_json(item))) return false;
  return true;
}

// Nothing if it is of another version.
std::optional<ManifestHead> head_of(const Json& json) {
  ManifestHead head;
  const std::string* version = string_field(json, "version");
  const Json* options = array_field(json, "options");
  const std::optional<int64_t> count = integer_field(json, "count");
  if (integer_field(json, kMark) != 1 || version == nullptr || options == nullptr || !count || *count < 0)
    return std::nullopt;
  head.version = *version;
  head.count = static_cast<uint64_t>(*count);
  for (const Json& option : *options) {
    if (!option.is_string()) return std::nullopt;
    head.options.push_back(*option.get_ptr<const Json::string_t*>());
  }
  return head;
}

namespace fs = std::filesystem;

void put_text(Json& object, const std::string& key, const std::string& text) {
  if (is_utf8(text))
    object[key] = text;
  else
    object[key + "_uri"] = percent_encode(text);
}

std::optional<std::string> text_of(const Json& object, const std::string& key) {
  if (const std::string* text = string_field(object, key.c_str())) return *text;
  if (const std::string* uri = string_field(object, (key + "_uri").c_str())) return percent_decode(*uri);
  return std::nullopt;
}

// A path below the output folder, in its shortest form. The batch's own folder begins with a dot and its name.
bool is_output_name(const std::string& name) {
  const fs::path path(name);
  if (name.find('\0') != std::string::npos) return false;
  if (name.empty() || path.has_root_path() || path.lexically_normal() != path || !path.has_filename())
    return false;
  return *path.begin() != ".." && !path.begin()->string().starts_with(".gltf-psplit-batch");
}

}  // namespace

Status write_manifest(const fs::path& path, const ManifestHead& head, std::span<const BatchItem> items,
                      IfReadOnly if_read_only) {
  return write_file(
      path, [&](std::FILE* file) { return write_lines(file, head, items); }, if_read_only);
}

Expected<Manifest> Manifest::open(const fs::path& path) {
  Expected<TextLines> lines = TextLines::open(path);
  if (!lines) return lines.status();
  Manifest manifest(std::move(*lines), path == "-" ? "stdin" : path.string());
  std::string_view line;
  if (!manifest.lines_.next(line)) return manifest;
  const Expected<Json> json = parse_json(line);
  // It decides what the file is: without its head, a plan would lose its options.
  if (!json) return manifest.invalid(json.status().message());
  if (field(*json, kMark) == nullptr) {
    manifest.first_ = std::string(line);
    return manifest;
  }
  manifest.head_ = head_of(*json);
  if (!manifest.head_) return manifest.invalid("the head of a plan that this version does not understand");
  return manifest;
}

Status Manifest::invalid(const std::string& why) const {
  return invalid_input("line " + std::to_string(lines_.number()) + ": " + why, {.file = name_});
}

Expected<std::optional<ManifestLine>> Manifest::next() {
  std::string_view line;
  const std::optional<std::string> first = std::exchange(first_, std::nullopt);
  if (first) line = *first;
  while (line.empty() || line == "\r") {
    if (lines_.next(line)) continue;
    if (!lines_.status().ok()) return lines_.status();
    if (head_ && head_->count != count_)
      return invalid("the plan has " + std::to_string(count_) + " assets instead of " +
                     std::to_string(head_->count));
    return std::optional<ManifestLine>();
  }
  ++count_;
  const Expected<Json> json = parse_json(line);
  Expected<BatchItem> item = json ? item_of(*json) : json.status();
  if (!item) item = invalid(item.status().message());
  return std::optional(ManifestLine{std::string(line), lines_.number(), std::move(item)});
}

Json to_json(const BatchItem& item) {
  Json json = Json::object();
  put_text(json, "input", item.input);
  put_text(json, "name", item.name);
  if (item.bytes) json["bytes"] = *item.bytes;
  if (!item.xxh128.empty()) json["xxh128"] = item.xxh128;
  if (!item.version.empty()) put_text(json, "version", item.version);
  return json;
}

Expected<BatchItem> item_of(const Json& json) {
  const std::optional<std::string> input = text_of(json, "input"), name = text_of(json, "name");
  if (!input || input->empty() || *input == "-" || input->find('\0') != std::string::npos)
    return invalid_input("there is no \"input\" that names a file");
  if (!name || !is_output_name(*name))
    return invalid_input("\"name\" must be a path below the output folder, such as \"x/y.glb\"");
  BatchItem item{.input = *input, .name = *name};
  if (field(json, "bytes") != nullptr) {
    const std::optional<int64_t> bytes = integer_field(json, "bytes");
    if (!bytes || *bytes < 0) return invalid_input("\"bytes\" must be a count");
    item.bytes = static_cast<uint64_t>(*bytes);
  }
  item.xxh128 = text_of(json, "xxh128").value_or("");
  if (field(json, "xxh128") != nullptr &&
      (item.xxh128.size() != 32 || item.xxh128.find_first_not_of("0123456789abcdef") != std::string::npos))
    return invalid_input("\"xxh128\" must be 32 hexadecimal digits");
  item.version = text_of(json, "version").value_or("");
  return item;
}

Expected<std::string> hash_file(const fs::path& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(open_file(path, "rb"), std::fclose);
  if (file == nullptr) return io_error("cannot open", errno, {.file = path.string()});
  ContentHash hash;
  std::vector<uint8_t> block(size_t{1} << 20);
  for (size_t got = block.size(); got == block.size();) {
    got = std::fread(block.data(), 1, block.size(), file.get());
    hash.add({block.data(), got});
  }
  if (std::ferror(file.get()) != 0) return io_error("cannot read", errno, {.file = path.string()});
  return hash.hex();
}

}  // namespace psplit
