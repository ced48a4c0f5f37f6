#include "tools/gltf_psplit/batch/batch_item.h"

#include <cerrno>
#include <cstdio>
#include <memory>
#include <vector>

#include "gltf_ext/files/content_hash.h"
#include "gltf_ext/files/io_error.h"
#include "gltf_ext/files/uri.h"
#include "gltf_ext/json/json_fields.h"
#include "gltf_ext/json/json_text.h"

namespace psplit {
namespace {

namespace fs = std::filesystem;

// The library that writes JSON does not accept other texts.
bool is_utf8(const std::string& text) {
  const Expected<Json> read = parse_json(Json(text).dump(-1, ' ', false, Json::error_handler_t::ignore));
  return read && *read == Json(text);
}

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
  if (name.empty() || path.is_absolute() || path.lexically_normal() != path || !path.has_filename())
    return false;
  return *path.begin() != ".." && !path.begin()->string().starts_with(".gltf-psplit-batch");
}

}  // namespace

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
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
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
