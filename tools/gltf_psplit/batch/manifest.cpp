#include "tools/gltf_psplit/batch/manifest.h"

#include "gltf_ext/files/files.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMark = "gltf_psplit_plan";

bool write_lines(std::FILE* file, const ManifestHead& head, std::span<const BatchItem> items) {
  const auto write = [&](const Json& json) {
    const std::string line = json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
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

}  // namespace psplit
